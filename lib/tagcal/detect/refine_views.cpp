#include "tagcal/detect/refine_views.hpp"

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/corner_error.hpp"
#include "tagcal/detect/checker_search/checker_corners.hpp"
#include "tagcal/detect/circle_search/circle_centres.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/picture_terms.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Parameters of a tag's bends. Each costs the logarithm of the number of pixels (BIC, Schwarz
// 1978).
constexpr int kNumBends = tag_parameter::kNumBends;

using Patterns = std::map<int, TagPattern>;

// A view some of whose observations were put by a fit.
struct FittedView {
  View view;
  std::set<CornerId> fitted;

  void put(Observation& seen, const Eigen::Vector2d& at, const Matrix2& covariance_px2) {
    seen.pixel = at;
    seen.covariance_px2 = covariance_px2;
    fitted.insert(seen.id);
  }

  // Puts a fitted tag. Returns the number of tags put: 1, or 0 without a fit.
  int put(const std::optional<TagFit>& fit, int id) {
    if (!fit) return 0;
    for (Observation& seen : view.observations)
      if (const int k = seen.id.corner; seen.id.tag_id == id)
        put(seen, fit->corners[static_cast<std::size_t>(k)],
            fit->covariance_px2.block<2, 2>(2 * k, 2 * k));
    return 1;
  }
};

// One view, whose corners of checkerboards and centres of circles are fitted under the lens, and
// its tags without and with bends, which paper that is not flat or an error of the lens may cause.
struct ViewRefinement {
  FittedView straight, bent;
  int num_tags = 0;
  int num_straight = 0, num_bent = 0;  // fitted tags
  double gain_of_bends = 0;            // of the BIC, over tags fitted in both ways
  int num_corners = 0, num_refined_corners = 0;

  void refine_checkers(const ImageView8& image, const Board& board, const Camera& camera) {
    const Checkerboard squares = checkers(board).value();
    CheckerCorners corners;
    std::map<CheckerCell, Observation*> seen;
    for (Observation& observation : straight.view.observations) {
      const int place = observation.id.tag_id - squares.first_id;
      if (observation.id.corner != 0 || place < 0 || place >= squares.columns * squares.rows)
        continue;
      const CheckerCell cell{place % squares.columns, place / squares.columns};
      seen[cell] = &observation;
      corners[cell].at = observation.pixel;
    }
    CheckerPrint print(board);
    CheckerCorners fitted = CheckerFitter(image, print, &camera).fit_again(corners);
    if (fitted.empty() && !tag_kind(board)) {
      // A board that looks the same after a turn may have the other colours.
      print.set_starts_black(!print.starts_black());
      fitted = CheckerFitter(image, print, &camera).fit_again(corners);
    }
    num_corners += static_cast<int>(corners.size());
    num_refined_corners += static_cast<int>(fitted.size());
    for (const auto& [cell, corner] : fitted)
      straight.put(*seen[cell], corner.at, corner.covariance_px2);
  }

  void refine_circles(const ImageView8& image, const CircleGrid& grid, const Camera& camera) {
    const CircleCentres on_board = centres_on_board(grid);
    CircleCentres centres;
    std::map<int, Observation*> seen;
    for (Observation& observation : straight.view.observations) {
      const auto centre = on_board.find(observation.id.tag_id);
      if (observation.id.corner != 0 || centre == on_board.end()) continue;
      seen[centre->first] = &observation;
      centres[centre->first] = {centre->second.on_board, observation.pixel};
    }
    num_corners += static_cast<int>(centres.size());
    num_refined_corners += fit_centres(image, &camera, centres);
    for (const auto& [id, centre] : centres)
      if (centre.covariance_px2.trace() > 0)
        straight.put(*seen[id], centre.at, centre.covariance_px2);
  }

  void refine_tags(const ImageView8& image, const Patterns& patterns, const Camera& camera) {
    bent = straight;
    std::vector<int> ids;
    const std::vector<TagInPicture> tags = whole_tags(patterns, camera, ids);
    num_tags = static_cast<int>(tags.size());
    const PictureTerms terms = terms_of_picture(image, tags);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      const auto fitted = [&](bool is_bent) {
        return fit_tag_with(terms, image, *tags[i].pattern, tags[i].corners,
                            {.camera = &camera, .is_rough = is_bent});
      };
      const auto one = fitted(false), other = fitted(true);
      num_straight += straight.put(one, ids[i]);
      num_bent += bent.put(other, ids[i]);
      if (one && other)
        gain_of_bends += 2 * one->num_pixels * std::log(one->noise_levels / other->noise_levels) -
                         kNumBends * std::log(one->num_pixels);
    }
  }

 private:
  std::vector<TagInPicture> whole_tags(const Patterns& patterns, const Camera& camera,
                                       std::vector<int>& ids) const {
    std::map<int, std::vector<const Observation*>> by_tag;
    for (const Observation& seen : straight.view.observations)
      by_tag[seen.id.tag_id].push_back(&seen);
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
};

// The views with bent or straight edges, whichever all of them together speak for. Observations
// that no fit has put keep their claims, which have the error of corners of their own detection.
RefinedViews chosen_views(std::vector<ViewRefinement>& refined, const ImageSize& size,
                          const std::vector<PlacedBoard>& boards) {
  RefinedViews result;
  std::vector<FittedView*> chosen;
  std::vector<ViewOfSize> views;
  double gain_of_bends = 0;
  for (const ViewRefinement& r : refined) gain_of_bends += r.gain_of_bends;
  const bool is_bent = gain_of_bends > 0;
  for (ViewRefinement& r : refined) {
    chosen.push_back(is_bent ? &r.bent : &r.straight);
    views.push_back({&chosen.back()->view, size});
    result.num_tags += r.num_tags;
    result.num_refined_tags += is_bent ? r.num_bent : r.num_straight;
    result.num_corners += r.num_corners;
    result.num_refined_corners += r.num_refined_corners;
  }
  result.corner_error_px = corner_error(views, boards);
  for (FittedView* one : chosen) {
    for (Observation& seen : one->view.observations)
      if (one->fitted.contains(seen.id)) widen_covariance(seen, result.corner_error_px);
    result.views.push_back(std::move(one->view));
  }
  return result;
}

}  // namespace

RefinedViews refine_views(const Dataset& found, const std::vector<ImageSource>& images,
                          const Camera& camera, int threads,
                          const std::function<void(int, int)>& progress) {
  const Patterns patterns = board_patterns(found.boards);
  std::map<std::string, const ImageSource*> by_name;
  for (const ImageSource& image : images) by_name[image.name] = &image;
  std::vector<ViewRefinement> refined;
  for (const View& view : found.views) refined.push_back({{view, {}}, {view, {}}});
  parallel_for(
      refined.size(), threads,
      [&](std::size_t i) {
        const std::string& name = refined[i].straight.view.image;
        const auto source = by_name.find(name);
        if (source == by_name.end()) return;
        const Image8 loaded = source->second->load();
        const PictureToSearch picture(loaded);
        const ImageView8 image = picture.pixels;
        check_size(&camera, image.size(), name);
        for (const PlacedBoard& placed : found.boards) {
          const auto* const grid = std::get_if<CircleGrid>(&placed.board.pattern);
          if (grid) refined[i].refine_circles(image, *grid, camera);
          if (checkers(placed.board)) refined[i].refine_checkers(image, placed.board, camera);
        }
        refined[i].refine_tags(image, patterns, camera);
      },
      progress);
  return chosen_views(refined, camera.image_size, found.boards);
}

}  // namespace tagcal
