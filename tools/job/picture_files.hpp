#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {

// Which frames of a video or bag are taken as pictures (frame_path).
struct FrameChoice {
  std::size_t every = 0;           // every so manyth; 0: those of walked_frames
  std::vector<std::size_t> these;  // those alone, if not empty
  bool is_auto() const { return every == 0 && these.empty(); }
};

// Where the frames of a video or bag went. Each counts once but in `all`.
struct FrameTally {
  std::size_t all = 0;
  std::size_t looked_at = 0;  // the rest is too near to another frame
  std::size_t with_board = 0;
  std::size_t fast = 0;     // the board moves too far from one frame to the next
  std::size_t no_pose = 0;  // no pose under the lens of the others
  std::size_t nothing = 0;  // would add next to nothing
  std::size_t used = 0;
};

// "auto", "evenly" (the same numbers in videos of one length: frames of several cameras belong
// together), "all", "every:N" or a text file with the number of a frame in each line. Throws Error.
FrameChoice frame_choice(const std::string& text);

// The name of a picture in answers and files of corners: its file name; of a frame without the
// ending and topic of its file ("clip@000123").
std::string picture_name(const std::filesystem::path& file);

// The picture files that arguments name, each once, in their order: a file; a video or a bag (its
// frames); a folder (every picture in it, by name); a pattern with * ? [ ] ('photos/*.png', the
// files it matches, by name); or
// @LIST, a text file with one of these a line. Empty lines and lines that begin with # are skipped;
// a path in a list is relative to the current folder or, if it is not there, to the list's.
// Pictures are not opened, videos and bags are. A folder without pictures stands for those in it.
// Notes (hold_note) say how many frames are taken of each video, and what it is unsuited for.
// `tally`: of the only video or bag, if nothing else is named and its frames are chosen. Throws
// Error for an argument that names no file, and for a file given twice.
std::vector<std::filesystem::path> picture_files(const std::vector<std::string>& arguments,
                                                 const FrameChoice& frames = {},
                                                 std::optional<FrameTally>* tally = nullptr);

// Files of a folder that people have beside pictures and that are not read: raw files, and videos
// and bags beside pictures. They are opened for the message that says what to do.
std::vector<std::filesystem::path> files_not_read(const std::filesystem::path& folder);

// Patterns that leave out pictures: by file name, or by the given path. Each may have * ? [ ].
class Exclusion {
 public:
  explicit Exclusion(const std::vector<std::string>& patterns);

  bool excludes(const std::filesystem::path& file);
  std::vector<std::string> unused() const;  // patterns that excluded nothing

 private:
  struct Pattern {
    std::string text;
    bool used = false;
  };
  std::vector<Pattern> patterns_;
};

// Removes the files that cannot be opened as pictures, and returns one message for each. Reads
// headers only.
std::vector<std::string> remove_unreadable(std::vector<std::filesystem::path>& files,
                                           std::vector<ImageHeader>& headers);

// The size that most pictures have; of several, the one that comes first. Throws Error, naming the
// others, if the sizes differ.
ImageSize common_size(const std::vector<std::filesystem::path>& files,
                      const std::vector<ImageHeader>& headers);

// Warns of pictures of one size that the camera turned by other angles, as upside down: the centre
// of their lens is at another place.
void warn_of_turns(const std::vector<std::filesystem::path>& files,
                   const std::vector<ImageHeader>& headers, std::vector<std::string>& warnings);

// What stdin sends, MJPEG or YUV4MPEG2 (.y4m), as a file that is removed at the end of the program:
// `ffmpeg .. -f mjpeg - | tagcal calibrate -`. Reads until the other end closes it, once. Throws
// Error: other bytes, nothing, no room.
std::filesystem::path piped_video();

// ".mjpeg" or ".y4m", as the first bytes that stdin sends say; "" if they are too few to tell.
// Throws Error for others.
std::string_view ending_of_video(std::string_view beginning);

}  // namespace tagcal::tools
