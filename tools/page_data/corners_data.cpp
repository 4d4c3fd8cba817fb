#include "page_data/page_parts.hpp"

#include <cmath>
#include <limits>
#include <set>

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::optional<Vector2d> reprojected(const PageContent& content, const CalibratedView& view,
                                    const Vector3d& x_in_world) {
  const Camera& camera = *content.calibration.camera;
  const Vector3d x = view.camera_from_world * x_in_world;
  if (view.scale_px_per_m)
    return Vector2d(*view.scale_px_per_m * x.head<2>() + image_centre(camera.image_size));
  return project(camera.lens, x);
}

// The standard deviation that the calibration gives to a corner.
double claimed_sd_px(const Calibration& calibration, const Observation& seen) {
  if (!calibration.sigma_of_corners)
    return calibration.sigma_px > 0 ? calibration.sigma_px : kUnknown;
  constexpr double kWithoutCovariance = 0.5;  // as CalibrateOptions::sigma_px
  const double variance = seen.covariance_px2 ? seen.covariance_px2->trace() / 2
                                              : kWithoutCovariance * kWithoutCovariance;
  return std::sqrt(variance + calibration.model_error_px * calibration.model_error_px);
}

}  // namespace

std::vector<PageCorner> page_corners(const PageContent& content) {
  const Calibration& calibration = content.calibration;
  std::set<std::pair<std::size_t, std::size_t>> outliers;
  for (const Outlier& o : calibration.outliers) outliers.emplace(o.view, o.corner);
  const auto points = bent_points_in_world(content.dataset.boards, calibration.board_warp);
  const bool answered = is_answer(calibration.status) && calibration.camera;
  std::vector<PageCorner> corners;
  for (std::size_t v = 0; v < content.dataset.views.size(); ++v) {
    const CalibratedView* const estimate = answered ? content.estimate_of(v) : nullptr;
    const auto& seen = content.dataset.views[v].observations;
    std::size_t inlier = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      PageCorner corner{v,
                        seen[i].id,
                        seen[i].pixel,
                        Vector2d::Constant(kUnknown),
                        (answered && !estimate) || outliers.contains({v, i}),
                        claimed_sd_px(calibration, seen[i])};
      const auto point = points.find(corner.id);
      if (estimate && point != points.end()) {
        if (!corner.rejected && inlier < estimate->residuals_px.size())
          corner.residual_px = -estimate->residuals_px[inlier++];
        else if (const auto p = reprojected(content, *estimate, point->second))
          corner.residual_px = corner.pixel - *p;
      }
      corners.push_back(corner);
    }
  }
  return corners;
}

PageJson corners_json(const std::vector<PageCorner>& corners) {
  PageJson columns;
  for (const char* name : {"view", "u", "v", "du", "dv", "rejected", "tag", "corner", "sd_px"})
    columns[name] = PageJson::array();
  for (const PageCorner& c : corners) {
    columns["view"].push_back(c.view);
    columns["u"].push_back(decimals(c.pixel.x(), 2));
    columns["v"].push_back(decimals(c.pixel.y(), 2));
    columns["du"].push_back(significant(c.residual_px.x(), 4));
    columns["dv"].push_back(significant(c.residual_px.y(), 4));
    columns["rejected"].push_back(c.rejected ? 1 : 0);
    columns["tag"].push_back(c.id.tag_id);
    columns["corner"].push_back(c.id.corner);
    columns["sd_px"].push_back(significant(c.sd_px, 3));
  }
  return columns;
}

}  // namespace tagcal::tools
