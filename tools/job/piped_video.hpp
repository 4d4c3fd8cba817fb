#pragma once

#include <filesystem>

namespace tagcal::tools {

// What stdin sends, MJPEG or YUV4MPEG2 (.y4m), as a file that is removed at the end of the program:
// `ffmpeg .. -f mjpeg - | tagcal calibrate -`. Reads until the other end closes it, once. Throws
// Error: other bytes, nothing, no room.
std::filesystem::path piped_video();

}  // namespace tagcal::tools
