#include "tagcal/detect/checker_search/refine_checkers.hpp"

#include <map>
#include <string>

#include "tagcal/detect/checker_search/checker_corners.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

struct RefinedView {
  View view;
  int num_corners = 0;
  int num_refined = 0;

  void refine(const ImageView8& image, const Board& board, const Camera& camera) {
    const Checkerboard squares = checkers(board).value();
    CheckerCorners corners;
    std::map<CheckerCell, Observation*> seen;
    for (Observation& observation : view.observations) {
      const int place = observation.id.tag_id - squares.first_id;
      if (observation.id.corner != 0 || place < 0 || place >= squares.columns * squares.rows)
        continue;
      const CheckerCell cell{place % squares.columns, place / squares.columns};
      seen[cell] = &observation;
      corners[cell].at = observation.pixel;
      corners[cell].covariance_px2 =
          observation.covariance_px2.value_or(Matrix2(Eigen::Matrix2d::Zero()));
    }
    CheckerPrint print(board);
    int refined = CheckerFitter(image, print, &camera).fit_again(corners);
    if (refined == 0 && !tag_kind(board)) {
      // A board that looks the same after a turn may have the other colours.
      print.set_starts_black(!print.starts_black());
      refined = CheckerFitter(image, print, &camera).fit_again(corners);
    }
    num_corners += static_cast<int>(corners.size());
    num_refined += refined;
    for (const auto& [cell, corner] : corners) {
      seen[cell]->pixel = corner.at;
      if (corner.covariance_px2.trace() > 0) seen[cell]->covariance_px2 = corner.covariance_px2;
    }
  }
};

}  // namespace

RefinedCorners refine_checkers(const std::vector<ImageSource>& images,
                               const std::vector<PlacedBoard>& boards,
                               const std::vector<View>& views, const Camera& camera, int threads) {
  std::map<std::string, const ImageSource*> by_name;
  for (const ImageSource& image : images) by_name[image.name] = &image;
  std::vector<const Board*> checkerboards;
  for (const PlacedBoard& placed : boards)
    if (checkers(placed.board)) checkerboards.push_back(&placed.board);
  RefinedCorners result{views};
  if (checkerboards.empty()) return result;
  std::vector<RefinedView> refined;
  for (const View& view : views) refined.push_back({view});
  parallel_for(views.size(), threads, [&](std::size_t i) {
    const auto source = by_name.find(views[i].image);
    if (source == by_name.end() || views[i].observations.empty()) return;
    const Image8 image = source->second->load();
    for (const Board* board : checkerboards) refined[i].refine(image, *board, camera);
  });
  for (std::size_t i = 0; i < refined.size(); ++i) {
    result.num_tags += refined[i].num_corners;
    result.num_refined += refined[i].num_refined;
    result.views[i] = std::move(refined[i].view);
  }
  return result;
}

}  // namespace tagcal::internal
