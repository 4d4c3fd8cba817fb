#include "tagcal/detect/board_search/refine_corners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/picture_gamma.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

// Parameters of a tag's bends. Each costs the logarithm of the number of pixels (BIC, Schwarz
// 1978).
constexpr int kNumBends = tag_parameter::kNumBends;

// The tags of one view, fitted under the lens without and with bends, which paper that is not flat
// or an error of the lens may cause.
struct ViewRefinement {
  View straight, bent;
  int num_tags = 0;
  int num_straight = 0, num_bent = 0;  // fitted tags
  double gain_of_bends = 0;            // of the BIC, over tags fitted in both ways

  void run(const ImageView8& image, const std::map<int, TagPattern>& patterns,
           const Camera& camera) {
    std::vector<int> ids;
    const std::vector<TagInPicture> tags = whole_tags(patterns, camera, ids);
    num_tags = static_cast<int>(tags.size());
    const double gamma = gamma_of_picture(image, tags);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      const auto fitted = [&](bool is_bent) {
        return fit_known_tag(image, *tags[i].pattern, tags[i].corners, {&camera, is_bent, gamma});
      };
      const auto one = fitted(false), other = fitted(true);
      num_straight += put(one, ids[i], straight);
      num_bent += put(other, ids[i], bent);
      if (one && other)
        gain_of_bends += 2 * one->num_pixels * std::log(one->noise_levels / other->noise_levels) -
                         kNumBends * std::log(one->num_pixels);
    }
  }

 private:
  std::vector<TagInPicture> whole_tags(const std::map<int, TagPattern>& patterns,
                                       const Camera& camera, std::vector<int>& ids) const {
    std::map<int, std::vector<const Observation*>> by_tag;
    for (const Observation& seen : straight.observations) by_tag[seen.id.tag_id].push_back(&seen);
    std::vector<TagInPicture> tags;
    for (const auto& [id, corners] : by_tag) {
      const auto pattern = patterns.find(id);
      if (pattern == patterns.end() || corners.size() != 4) continue;
      ids.push_back(id);
      TagInPicture& tag = tags.emplace_back();
      tag.pattern = &pattern->second;
      tag.camera = &camera;
      for (const Observation* c : corners)
        tag.corners[static_cast<std::size_t>(c->id.corner)] = c->pixel;
    }
    return tags;
  }

  // Puts a fitted tag into the view. Returns the number of tags put: 1, or 0 without a fit.
  static int put(const std::optional<TagFit>& fit, int id, View& view) {
    if (!fit) return 0;
    for (Observation& seen : view.observations) {
      if (seen.id.tag_id != id) continue;
      seen.pixel = fit->corners[static_cast<std::size_t>(seen.id.corner)];
      seen.covariance_px2 = fit->covariance_px2.block<2, 2>(2 * seen.id.corner, 2 * seen.id.corner);
    }
    return 1;
  }
};

}  // namespace

RefinedCorners refine_corners(const std::vector<ImageSource>& images,
                              const std::vector<PlacedBoard>& boards,
                              const std::vector<View>& views, const Camera& camera, int threads,
                              const std::function<void(int, int)>& progress) {
  const std::map<int, TagPattern> patterns = board_patterns(boards);
  std::map<std::string, const ImageSource*> by_name;
  for (const ImageSource& image : images) by_name[image.name] = &image;
  std::vector<ViewRefinement> refined;
  for (const View& view : views) refined.push_back({view, view});
  parallel_for(
      views.size(), threads,
      [&](std::size_t i) {
        const auto source = by_name.find(views[i].image);
        if (source == by_name.end()) return;
        const Image8 image = source->second->load();
        if (image.size() != camera.image_size)
          throw Error(fmt::format("{}: must be {}x{} pixels as the camera's, got {}x{}",
                                  views[i].image, camera.image_size.width, camera.image_size.height,
                                  image.width(), image.height()));
        refined[i].run(image, patterns, camera);
      },
      progress);
  RefinedCorners result;
  double gain_of_bends = 0;
  for (const ViewRefinement& r : refined) gain_of_bends += r.gain_of_bends;
  const bool is_bent = gain_of_bends > 0;
  for (ViewRefinement& r : refined) {
    result.views.push_back(std::move(is_bent ? r.bent : r.straight));
    result.num_tags += r.num_tags;
    result.num_refined += is_bent ? r.num_bent : r.num_straight;
  }
  return result;
}

}  // namespace tagcal::internal
