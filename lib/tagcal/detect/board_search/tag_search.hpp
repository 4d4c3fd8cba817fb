#pragma once

#include <optional>
#include <set>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"
#include "tagcal/detect/opencv/picture_shift.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

// The tags of one family and border in a picture.
struct SeenTags {
  std::vector<FoundTag> tags;           // of a search without boards
  std::vector<Completion> completions;  // for each board
  std::set<int> strange;                // ids of the family that are on no board
  std::set<int> repeated;               // ids seen at more than one place, which are not reported
  PictureTerms terms;                   // of the fits
};

// Finds the tags of one family and border: those of boards, or all of them. Halved pictures are
// searched first, which is quick and shows large tags in noise; boards are completed from these.
// Tags that are still missing, and may be in the picture, are searched for in less halved ones,
// only where they may be. A picture that shows no tag at all and is not large is doubled: then tags
// are read down to 10 px. With Refinement::fit, tags are fitted, strongly bent ones too, then again
// with the picture's terms, and tags without a fit are dropped. Pictures with a side below 8
// px are not searched.
class TagSearch {
 public:
  // The boards must outlive it and be of one family and border. Throws Error as tag_family() does.
  TagSearch(std::vector<const Board*> boards, const DetectOptions& options);
  // Every tag of a family.
  TagSearch(const TagKind& kind, const DetectOptions& options);

  const Wanted& wanted() const { return detector_.wanted(); }
  const TagFamily& family() const { return family_; }

  SeenTags find(const ImageView8& image);

  // The boards' tags of the next picture of a sequence, where those of the picture before lead. No
  // value if a tag is lost, or if the picture before did not show every panel of the boards: then
  // the picture is to be searched. Terms that it does not have are not estimated again.
  std::optional<SeenTags> follow(const ImageView8& image, const SeenTags& before,
                                 const PictureShift& shift);

 private:
  TagSearch(const Wanted& wanted, std::vector<const Board*> boards, const DetectOptions& options);
  void search_scales(const ImageView8& image, SeenTags& seen);
  void search_bent(const ImageView8& image, SeenTags& seen);
  void search(const ImageView8& image, const Search& where, SeenTags& seen);
  std::vector<FoundTag> unique_tags(const std::vector<FoundTag>& tags, SeenTags& seen) const;
  void complete(const ImageView8& image, const std::vector<FoundTag>& tags, SeenTags& seen);
  void fit(const ImageView8& image, SeenTags& seen);
  void fit_bent(const ImageView8& image, SeenTags& seen) const;
  void fit_with_terms(const ImageView8& image, SeenTags& seen);
  std::optional<std::vector<FoundTag>> followed_tags(const ImageView8& image,
                                                     const SeenTags& before,
                                                     const PictureShift& shift) const;

  std::vector<const Board*> boards_;  // none: every tag is wanted
  DetectOptions options_;
  FamilyDetector detector_;
  TagFamily family_;
};

// A search for each family and border of the boards, which must outlive the searches.
std::vector<TagSearch> tag_searches(const std::vector<PlacedBoard>& boards,
                                    const DetectOptions& options);

}  // namespace tagcal::internal
