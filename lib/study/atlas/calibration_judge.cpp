#include "study/atlas/calibration_judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "study/atlas/stability_judge.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool of_camera_matrix(std::string_view name) {
  constexpr std::array<std::string_view, 5> kNames = {"f", "fx", "fy", "cx", "cy"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

VectorXd free_error(const Model& model, const Lens& estimate, const Lens& truth) {
  const std::vector<double> a = model.free_values(estimate), b = model.free_values(truth);
  return Eigen::Map<const VectorXd>(a.data(), model.num_free()) -
         Eigen::Map<const VectorXd>(b.data(), model.num_free());
}

bool same_lens(const Lens& a, const Lens& b) { return a.index() == b.index(); }

bool gross(const Lens& estimate, const Lens& truth) {
  const double ratio = parameters(estimate)[0] / parameters(truth)[0];
  return !(ratio < kGrossFocalRatio && ratio > 1 / kGrossFocalRatio);
}

}  // namespace

CalibrationJudge::CalibrationJudge(CalibrationQuestion question)
    : question_(std::move(question)), bound_px_(std::numeric_limits<double>::quiet_NaN()) {
  const CalibrationTask& good = question_.good;
  truth_ = {good.lens, good.dataset.image_size};
  std::vector<Eigen::Vector2d> pixels;
  for (const View& view : good.dataset.views)
    for (const Observation& o : view.observations) pixels.push_back(o.pixel);
  samples_ = SeenRegion(truth_.image_size, pixels).samples();
  const auto bound = exact_inverse(calibration_information(good));
  if (!bound || samples_.size() < 6) {
    question_.knowable = false;
    return;
  }
  const Model& model = Model::named(good.model);
  const MatrixXd jacobian =
      aligned_jacobian({&model, {good.lens, truth_.image_size}, *bound}, samples_, kInfinitelyFar);
  const double square = (jacobian.transpose() * jacobian * *bound).trace();
  bound_px_ = std::sqrt(2 * square / static_cast<double>(jacobian.rows()));
  const double focal_share = std::sqrt((*bound)(0, 0)) / parameters(good.lens)[0];
  question_.knowable &=
      focal_share < kKnownFocalShare && bound_px_ / std::sqrt(2.0) < kKnownProjectionPx;
}

bool CalibrationJudge::right_camera_matrix(const LensAnswer& answer) const {
  if (!same_lens(answer.claim.camera.lens, truth_.lens)) return right_projection(answer);
  const Model& model = *answer.claim.model;
  std::vector<Index> judged;
  for (Index i = 0; i < model.num_free(); ++i)
    if (of_camera_matrix(model.free()[static_cast<std::size_t>(i)].name)) judged.push_back(i);
  const VectorXd error = free_error(model, answer.claim.camera.lens, truth_.lens)(judged);
  const auto information = exact_inverse(answer.claim.covariance(judged, judged));
  return information &&
         error.dot(*information * error) <= five_sigma_square(static_cast<int>(judged.size()));
}

// The sum of squares of a normal vector with covariance S = A C A' has the mean tr S and the
// variance 2 tr S^2, like a scaled chi-square with (tr S)^2 / tr S^2 degrees of freedom
// (Satterthwaite, Biometrics 1946).
bool CalibrationJudge::right_projection(const LensAnswer& answer) const {
  const auto difference = lens_difference(truth_, answer.claim.camera, samples_, kInfinitelyFar);
  if (!difference) return false;
  const MatrixXd a = aligned_jacobian(answer.claim, samples_, kInfinitelyFar);
  const MatrixXd product = a.transpose() * a * answer.claim.covariance;
  const double trace = product.trace();
  const double dof = trace * trace / (product * product).trace();
  if (!(dof > 0)) return false;
  const double mean_square = difference->rms_px * difference->rms_px;
  const double claimed_square = 2 * trace / static_cast<double>(a.rows());
  return mean_square <= claimed_square * five_sigma_square(std::max(1, static_cast<int>(dof))) /
                            std::max(1.0, std::floor(dof));
}

// A corner without a ray in the estimated lens is not judged.
bool CalibrationJudge::right_at_corners(const LensAnswer& answer) const {
  const auto difference = lens_difference(truth_, answer.claim.camera, samples_, kInfinitelyFar);
  if (!difference) return false;
  const ImageGrid& grid = difference->grid;
  const ProjectionUncertainty claimed =
      projection_uncertainty(answer.claim, grid, samples_, kInfinitelyFar);
  const double limit = std::sqrt(five_sigma_square(2));
  for (const int row : {0, grid.rows - 1})
    for (const int column : {0, grid.columns - 1}) {
      const double sigma = claimed.sigma_px(row, column);
      const double error = std::hypot(difference->u_px(row, column), difference->v_px(row, column));
      if (std::isfinite(sigma) && std::isfinite(error) && error > limit * sigma) return false;
    }
  return true;
}

bool CalibrationJudge::right_by_bound(const LensAnswer& answer) const {
  if (!same_lens(answer.claim.camera.lens,
                 truth_.lens)) {  // no parameters in common: by projections
    const auto difference = lens_difference(truth_, answer.claim.camera, samples_, kInfinitelyFar);
    return difference && difference->rms_px <= 5 * bound_px_;
  }
  if (gross(answer.claim.camera.lens, truth_.lens)) return false;
  CalibrationTask asked = question_.good;
  asked.model = answer.claim.model->name();
  const Model& model = *answer.claim.model;
  const VectorXd error = free_error(model, answer.claim.camera.lens, truth_.lens);
  return error.dot(calibration_information(asked) * error) <= five_sigma_square(model.num_free());
}

bool CalibrationJudge::right(const LensAnswer& answer) const {
  if (answer.claim.covariance.size() == 0) return right_by_bound(answer);
  switch (question_.judged) {
    case JudgedLens::camera_matrix:
      return right_camera_matrix(answer);
    case JudgedLens::projection:
      return right_projection(answer);
    case JudgedLens::image_corners:
      return right_at_corners(answer);
  }
  return false;
}

StabilityVerdict CalibrationJudge::judge(const LensAnswer& answer, bool may_refuse) const {
  StabilityVerdict verdict;
  verdict.said = answer.said;
  if (!answer.success) {
    verdict.outcome = question_.knowable && !may_refuse ? StabilityOutcome::right_but_refused
                                                        : StabilityOutcome::wrong_and_said;
    return verdict;
  }
  if (samples_.size() < 6) {
    verdict.outcome = StabilityOutcome::wrong_and_silent;
    return verdict;
  }
  const auto difference = lens_difference(truth_, answer.claim.camera, samples_, kInfinitelyFar);
  if (difference) verdict.over_bound = difference->rms_px / bound_px_;
  verdict.outcome = right(answer)    ? StabilityOutcome::right_and_said
                    : answer.doubted ? StabilityOutcome::wrong_and_said
                                     : StabilityOutcome::wrong_and_silent;
  return verdict;
}

}  // namespace tagcal::study
