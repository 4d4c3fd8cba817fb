#include "tagcal/detect/apriltag/kind_search.hpp"

#include <algorithm>
#include <memory>

#include "tagcal/detect/apriltag/sightings.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/refine_edges.hpp"

namespace tagcal::internal {
namespace {

class KindSearch {
 public:
  explicit KindSearch(const std::vector<TagKind>& wanted) : detector_(apriltag_detector_create()) {
    for (const TagKind& kind : wanted) {
      families_.push_back(shared_family(kind.family, kind.border_bits, 0));
      apriltag_detector_add_family_bits(detector_.get(), families_.back().get(), 0);
      found_.push_back({kind, {}});
    }
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;
    detector_->refine_edges = false;  // ours, below
  }

  KindsInPicture run(const ImageView8& image) {
    KindsInPicture result;
    for (const int shrink : policy::kTagShrinksPx) {
      for (const Sighting& seen : sightings(*detector_, image, shrink)) add(image, seen);
      result.quads = std::max(result.quads, static_cast<int>(detector_->nquads));
    }
    for (TagsOfKind& kind : found_)
      if (!kind.tags.empty()) result.kinds.push_back(std::move(kind));
    return result;
  }

 private:
  void add(const ImageView8& image, const Sighting& seen) {
    const auto of_family = std::ranges::find(families_, seen.family, &FamilyHandlePtr::get);
    std::vector<FoundTag>& tags =
        found_[static_cast<std::size_t>(of_family - families_.begin())].tags;
    const bool is_known = std::ranges::any_of(tags, [&](const FoundTag& tag) {
      return tag.id == seen.id && are_one_tag(tag.corners, seen.corners);
    });
    if (is_known || !is_inside(seen.corners, image.size())) return;
    const QuadShape shape{seen.family->width_at_border, !seen.family->reversed_border};
    tags.push_back({seen.id, refine_edges(image, seen.corners, shape).value_or(seen.corners)});
  }

  using FamilyHandlePtr = std::shared_ptr<apriltag_family_t>;
  std::vector<FamilyHandlePtr> families_;
  DetectorHandle detector_;
  std::vector<TagsOfKind> found_;  // for each family
};

}  // namespace

KindsInPicture search_kinds(const ImageView8& image, const std::vector<TagKind>& wanted) {
  return KindSearch(wanted).run(image);
}

std::vector<TagKind> all_kinds() {
  std::vector<TagKind> kinds;
  for (const std::string& family : tag_family_names()) {
    const int widest = tag_family(family, 1).reversed_border ? 1 : 2;
    for (int border = 1; border <= widest; ++border) kinds.push_back({family, border});
  }
  return kinds;
}

}  // namespace tagcal::internal
