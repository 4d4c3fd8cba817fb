#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/detect/opencv/picture_shift.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect: the search for all boards in pictures, one after the other.
namespace tagcal::internal {

// Not thread-safe.
class PictureSearch {
 public:
  // The boards must outlive it. Throws Error as tag_family() does.
  PictureSearch(const std::vector<PlacedBoard>& boards, const DetectOptions& options);

  // Searches a picture: detect() without the error of corners beyond their fits.
  DetectedPicture find(const ImageView8& image, const std::string& name);
  // The same for the first picture of a sequence.
  DetectedPicture find_first(const ImageView8& image, const std::string& name);
  // The same for the picture after the last one of a sequence: looks where the boards were, and
  // searches all of it if that one did not show every board, or if anything is lost.
  DetectedPicture find_next(const ImageView8& image, const std::string& name);

  bool has_followed() const { return has_followed_; }  // the last picture was not searched

 private:
  // The tags and squares that were found in a picture.
  struct Seen {
    ReducedPicture reduced;      // empty for a picture that is not in a sequence
    std::vector<SeenTags> tags;  // of each search
    std::vector<SeenChecker> checkers;
  };

  DetectedPicture find(const ImageView8& image, const std::string& name, bool in_sequence,
                       std::optional<Seen> before = {});
  void search(const ImageView8& image, const std::string& name, std::optional<Seen> before,
              Seen seen, DetectedPicture& found);
  void search(const ImageView8& image, Seen& seen);
  bool follow(const ImageView8& image, const Seen& before, Seen& seen);
  void add_tags(const ImageView8& image, const std::string& name, DetectedPicture& found) const;
  void add_checkers(const std::string& name, DetectedPicture& found) const;
  void add_circles(const ImageView8& image, const std::string& name, DetectedPicture& found) const;

  const Camera* camera_;
  std::vector<TagSearch> searches_;
  CheckerFinder checkers_;
  CircleFinder circles_;
  std::optional<Seen> last_;  // no value if the last picture was not searched
  bool has_followed_ = false;
};

}  // namespace tagcal::internal
