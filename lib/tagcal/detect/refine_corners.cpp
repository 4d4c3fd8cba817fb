#include "tagcal/detect/refine_corners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "tagcal/detect/board_patterns.hpp"
#include "tagcal/detect/known_tag.hpp"
#include "tagcal/detect/picture_batch.hpp"
#include "tagcal/detect/picture_gamma.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

// Fits the tags of one view; counts those that it moved.
struct ViewRefinement {
  View view;
  int num_tags = 0;
  int num_refined = 0;

  void run(const Image8& image, const std::map<int, TagPattern>& patterns, const Camera& camera) {
    std::map<int, std::vector<Observation*>> by_tag;
    for (Observation& seen : view.observations) by_tag[seen.id.tag_id].push_back(&seen);
    std::vector<TagInPicture> tags;
    std::vector<int> ids;
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
    num_tags = static_cast<int>(tags.size());
    const double gamma = gamma_of_picture(image, tags);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      const auto fit =
          fit_known_tag(image, *tags[i].pattern, tags[i].corners, {&camera, false, gamma});
      if (!fit) continue;
      ++num_refined;
      for (Observation* c : by_tag[ids[i]]) {
        c->pixel = fit->corners[static_cast<std::size_t>(c->id.corner)];
        c->covariance_px2 = fit->covariance_px2.block<2, 2>(2 * c->id.corner, 2 * c->id.corner);
      }
    }
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
  for (const View& view : views) refined.push_back({view});
  std::vector<int> workers(
      std::clamp<std::size_t>(views.size(), 1, static_cast<std::size_t>(threads_of(threads))));
  for_each_picture(
      views.size(), workers,
      [&](int, std::size_t i) {
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
  for (ViewRefinement& r : refined) {
    result.views.push_back(std::move(r.view));
    result.num_tags += r.num_tags;
    result.num_refined += r.num_refined;
  }
  return result;
}

}  // namespace tagcal
