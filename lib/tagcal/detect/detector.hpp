#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

namespace tagcal {

// Finds the corners of the boards' tags and checkerboards and the centres of their circles in one
// picture. Tags that are on no board, and tags of one id seen at two places, are not reported but
// named in the warnings, which begin with `name`, as does an Error. Pictures with a side below 8 px
// are not searched. Corners: pixel centres at whole numbers. Throws Error if the picture's size
// differs from that of the given camera.
DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options = {}, const std::string& name = "picture");

// The same for many pictures, in parallel, in their order; frames of a sequence as by BoardTracker,
// with a whole search each 20 frames. The answer does not depend on the number of threads.
// `progress(done, total)` is called under a lock after each image. Throws what loading a picture
// throws, unless DetectOptions::skip_unreadable.
std::vector<DetectedPicture> detect_all(const std::vector<ImageSource>& images,
                                        const std::vector<PlacedBoard>& boards,
                                        const DetectOptions& options = {},
                                        const std::function<void(int, int)>& progress = {});

// Finds the boards in the pictures of a sequence, one after the other: looks where the board was in
// the picture before, at about half the cost of detect(), and searches the whole picture
// again if a tag or corner is lost, if the picture before did not show each board (of a board with
// several planes each plane), or showed strange or repeated tags. Corners are those of detect()
// but for what the iterations of a fit leave (docs/tasks/pictures.md). New tags of a board are
// found from those that are seen; tags on no board are only noticed in whole searches. A board may
// move by up to an eighth of the picture's longer side from picture to picture. Not thread-safe.
class BoardTracker {
 public:
  // The objects that DetectOptions refers to must outlive it. Throws Error as detect().
  explicit BoardTracker(std::vector<PlacedBoard> boards, const DetectOptions& options = {});
  ~BoardTracker();
  BoardTracker(BoardTracker&&) noexcept;
  BoardTracker& operator=(BoardTracker&&) noexcept;

  // As detect(); the error of corners is that of the last picture that was searched.
  DetectedPicture next(const ImageView8& image, const std::string& name = "picture");
  // True if the last picture was not searched: the picture before led to all tags.
  bool has_followed() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The views of a data set.
std::vector<View> views_of(const std::vector<DetectedPicture>& pictures);

// Finds every tag of a family in one picture, without a board: each lies whole in the picture, and
// each place is reported once, ordered by id and, where an id is repeated, from left to right.
// Corners are refined as by detect(). A lens that bends the sides of a large tag is known only from
// DetectOptions::camera. Pictures with a side below 8 px show none.
// Throws Error as tag_family() does, and if the picture's size differs from the camera's.
std::vector<DetectedTag> detect_tags(const ImageView8& image, const TagKind& kind,
                                     const DetectOptions& options = {});

// The same for many pictures, as detect_all().
std::vector<PictureTags> detect_all_tags(const std::vector<ImageSource>& images,
                                         const TagKind& kind, const DetectOptions& options = {},
                                         const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
