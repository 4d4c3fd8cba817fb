// Poses, with and without focal length, of structured random problems.
#include <Eigen/Cholesky>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "tagcal/estimate/pose.hpp"

namespace {

using namespace tagcal;

struct Problem {
  Camera camera;
  std::vector<Correspondence> seen;
  std::vector<Matrix2> covariances;
  std::vector<int> groups;
};

Camera camera_of(fuzz::Bytes& bytes) {
  const ImageSize size{bytes.whole(8, 4000), bytes.whole(8, 3000)};
  const double f = bytes.number(0.1, 5) * size.width;
  const Eigen::Vector2d c = image_centre(size);
  switch (bytes.byte() % 4) {
    case 0:
      return {pinhole(f, f, c.x(), c.y()), size};
    case 1:
      return {Perspective({f, f * bytes.number(0.5, 2), c.x(), c.y(), bytes.number(-1, 1),
                           bytes.number(-1, 1), bytes.number(-0.1, 0.1), bytes.number(-0.1, 0.1),
                           bytes.number(-1, 1), 0, 0, 0}),
              size};
    case 2:
      return {Fisheye({f, f, c.x(), c.y(), bytes.number(-1, 1), bytes.number(-1, 1), 0, 0}), size};
    default:
      return {Parallel({f, f, c.x(), c.y(), 0, 0}), size};
  }
}

// Points in a plane, in space, on a line or all in one place, seen from a pose or anywhere.
Problem problem_of(fuzz::Bytes& bytes) {
  Problem problem{camera_of(bytes), {}, {}, {}};
  const int kind = bytes.byte() % 6;
  const int num_points = bytes.byte() % 40;
  const double unit = std::pow(10.0, bytes.whole(-6, 6));
  const Pose pose(
      exp_rotation({bytes.number(-4, 4), bytes.number(-4, 4), bytes.number(-4, 4)}),
      unit * Eigen::Vector3d(bytes.number(-2, 2), bytes.number(-2, 2), bytes.number(-0.5, 20)));
  const double noise = bytes.flag() ? bytes.number(0, 20) : 0;
  for (int i = 0; i < num_points; ++i) {
    Eigen::Vector3d x(bytes.wild(-1, 1), bytes.wild(-1, 1), bytes.wild(-1, 1));
    if (kind <= 2) x.z() = 0;
    if (kind == 3) x = Eigen::Vector3d(x.x(), 2 * x.x(), 0);
    if (kind == 4) x.setZero();
    x *= unit;
    Eigen::Vector2d pixel(bytes.wild(-10, problem.camera.image_size.width),
                          bytes.wild(-10, problem.camera.image_size.height));
    if (kind != 1) {
      if (const auto projected = project(problem.camera.lens, pose * x))
        pixel = *projected + noise * Eigen::Vector2d(bytes.number(-1, 1), bytes.number(-1, 1));
    }
    problem.seen.push_back({x, pixel});
    Matrix2 covariance = Matrix2::Identity() * bytes.wild(1e-4, 1);
    covariance(0, 1) = covariance(1, 0) = covariance(0, 0) * bytes.number(-1.1, 1.1);
    problem.covariances.push_back(covariance);
    problem.groups.push_back(i / 4);
  }
  return problem;
}

void check_hypotheses(const std::vector<PoseHypothesis>& hypotheses) {
  double sum = 0;
  for (const PoseHypothesis& h : hypotheses) {
    fuzz::require(h.camera_from_target.matrix().allFinite(), "poses are finite");
    fuzz::require(h.covariance.diagonal().minCoeff() >= 0, "variances are not negative");
    fuzz::require(std::isfinite(h.rms_px) && h.rms_px >= 0, "residuals are finite");
    fuzz::require(h.probability >= 0 && h.probability <= 1 + 1e-9, "probabilities are in [0, 1]");
    sum += h.probability;
  }
  fuzz::require(std::abs(sum - 1) < 1e-6, "probabilities sum to one");
}

template <typename Estimate>
void check_estimate(const Estimate& estimate, std::size_t num_points) {
  for (const std::size_t i : estimate.outliers)
    fuzz::require(i < num_points, "outliers are points of the input");
  if (is_answer(estimate.status)) {
    check_hypotheses(estimate.hypotheses);
    fuzz::require(std::isfinite(estimate.sigma_px) && estimate.sigma_px >= 0, "noise is finite");
  } else {
    bool has_reason = false;
    for (const Finding& finding : estimate.findings)
      has_reason = has_reason || finding.severity == Severity::refusal;
    fuzz::require(has_reason, "a refusal has a reason");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  Problem problem;
  const unsigned options_of = bytes.byte();
  if (!fuzz::is_accepted([&] { problem = problem_of(bytes); })) return 0;
  PoseAndFocalOptions options;
  options.reject_outliers = options_of % 2 == 0;
  if (options_of & 2U) options.sigma_px = 0.5;
  if (options_of & 4U) options.covariance_px2 = problem.covariances;
  if (options_of & 8U) options.groups = problem.groups;
  if (options_of & 16U) options.prior_focal_px = 500;
  fuzz::is_accepted([&] {
    check_estimate(estimate_pose(problem.seen, problem.camera, options), problem.seen.size());
  });
  fuzz::is_accepted([&] {
    const auto estimate = estimate_pose_and_focal(problem.seen, problem.camera.image_size, options);
    check_estimate(estimate, problem.seen.size());
    if (!is_answer(estimate.status)) return;
    fuzz::require(std::isfinite(estimate.focal_px) && estimate.focal_px > 0, "f is finite");
    fuzz::require(estimate.sigma_focal_px >= 0, "sd of f is not negative");
  });
  return 0;
}
