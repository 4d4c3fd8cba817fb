#pragma once

#include <filesystem>
#include <string_view>

namespace tagcal::tools {

// What stdin sends, MJPEG or YUV4MPEG2 (.y4m), as a file that is removed at the end of the program:
// `ffmpeg .. -f mjpeg - | tagcal calibrate -`. Reads until the other end closes it, once. Throws
// Error: other bytes, nothing, no room.
std::filesystem::path piped_video();

// ".mjpeg" or ".y4m", as the first bytes that stdin sends say; "" if they are too few to tell.
// Throws Error for others.
std::string_view ending_of_video(std::string_view beginning);

}  // namespace tagcal::tools
