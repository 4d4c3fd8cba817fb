#include "tagcal/estimate/camera_check/candidates.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/check_policy.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// RMS and largest length of the displacements of the samples.
std::pair<double, double> lengths(const VectorXd& pixels) {
  double most = 0;
  for (Index i = 0; i + 1 < pixels.size(); i += 2)
    most = std::max(most, pixels.segment<2>(i).norm());
  return {
      std::sqrt(2 * pixels.squaredNorm() / static_cast<double>(std::max<Index>(1, pixels.size()))),
      most};
}

// The largest of the displacements without the part that is a change of all lengths alike.
double without_scale(const PossibleChange& candidate, const VectorXd& change, const FreeFit& fit) {
  VectorXd pixels = candidate.pixels * change;
  const auto connected = std::ranges::count(fit.connected.cameras, 1);
  if (candidate.kind == ChangeKind::place && connected == 2) {
    VectorXd by_scale = VectorXd::Zero(6);
    by_scale.tail<3>() = fit.state.poses.camera_from_rig[candidate.camera].translation();
    const VectorXd scaled = candidate.pixels * by_scale;
    if (scaled.squaredNorm() > 0) pixels -= scaled * (scaled.dot(pixels) / scaled.squaredNorm());
  }
  return lengths(pixels).second;
}

// The kinds of change of the cameras of a free fit.
class Candidates {
 public:
  Candidates(const FreeFit& fit, Index size) : fit_(fit), layout_(fit.state, fit.connected) {
    const auto connected = std::ranges::count(fit.connected.cameras, 1);
    for (std::size_t c = 0; c < fit.state.cameras.size(); ++c) {
      if (fit.cameras[c].num_views == 0) continue;
      add_lens(c, size);
      // Two cameras show their relative place only: a move of either is named as
      // one of the camera that is not the reference.
      const bool is_reference = c == fit.state.poses.reference;
      if (layout_.pose[c] || (is_reference && connected > 2)) add_place(c, size);
    }
    std::ranges::stable_sort(all_, {}, [](const PossibleChange& c) { return c.basis.cols(); });
  }

  const std::vector<PossibleChange>& all() const { return all_; }

 private:
  void add_lens(std::size_t c, Index size) {
    const Bundle& bundle = fit_.state.cameras[c];
    const Index k = bundle.model->num_free();
    VectorXd focal = VectorXd::Zero(k);
    MatrixXd centre = MatrixXd::Zero(k, 0);
    for (std::size_t i = 0; i < bundle.free_values.size(); ++i) {
      const auto at = static_cast<Index>(i);
      const ParameterRole role = bundle.model->parameter(i).role;
      if (role == ParameterRole::focal_length) focal[at] = bundle.free_values[i];
      if (role != ParameterRole::principal_point) continue;
      centre.conservativeResize(k, centre.cols() + 1);
      centre.col(centre.cols() - 1) = VectorXd::Unit(k, at);
    }
    const MatrixXd rows = aligned_jacobian({bundle.model, {bundle.lens(), bundle.image_size}, {}},
                                           seen_region(bundle).samples(), kInfinitelyFar);
    const auto add = [&](ChangeKind kind, const MatrixXd& basis) {
      MatrixXd of_all = MatrixXd::Zero(size, basis.cols());
      of_all.middleRows(layout_.lens[c], k) = basis;
      all_.push_back({c, kind, of_all, rows * basis});
    };
    MatrixXd both(k, 1 + centre.cols());
    both << focal, centre;
    if (!focal.isZero()) add(ChangeKind::focal_length, focal);
    if (centre.cols() > 0) add(ChangeKind::principal_point, centre);
    if (!focal.isZero() && centre.cols() > 0) add(ChangeKind::focal_and_centre, both);
    if (k > both.cols()) add(ChangeKind::lens, MatrixXd::Identity(k, k));
  }

  void add_place(std::size_t c, Index size) {
    MatrixXd basis = MatrixXd::Zero(size, 6);
    if (layout_.pose[c]) {
      basis.middleRows<6>(*layout_.pose[c]).setIdentity();
    } else {
      // The reference moves before the others: each of them moves behind it the other way.
      for (std::size_t other = 0; other < layout_.pose.size(); ++other)
        if (const auto at = layout_.pose[other])
          basis.middleRows<6>(*at) = -step_by(
              fit_.state.poses.camera_from_rig[other].rotation_matrix(), Eigen::Vector3d::Zero());
    }
    all_.push_back({c, ChangeKind::place, basis, corners_by_place(c)});
  }

  // The corners of some views by the step of the camera's place.
  MatrixXd corners_by_place(std::size_t c) const {
    constexpr std::size_t kEnough = 20;  // numeric: a limit of work
    const Bundle& bundle = fit_.state.cameras[c];
    MatrixXd rows(0, 6);
    for (const std::size_t v : spread_indices(bundle.views.size(), kEnough)) {
      std::vector<Eigen::Vector3d> points;
      for (const Correspondence& corner : bundle.views[v].correspondences)
        points.push_back(corner.point);
      const auto projected = projection_rows(bundle.lens(), bundle.camera_from_target[v], points);
      if (!projected) continue;
      const LinkedSteps steps(fit_.state.poses, c, fit_.state.poses.links[c][v]);
      const Index before = rows.rows(), more = projected->by_pose.rows();
      rows.conservativeResize(before + more, 6);
      rows.bottomRows(more) = projected->by_pose * steps.by_camera;
    }
    return rows;
  }

  const FreeFit& fit_;
  RigLayout layout_;
  std::vector<PossibleChange> all_;
};

// The coefficients in the parameters that people read, with their standard deviations.
std::vector<ParameterChange> parameter_changes(const PossibleChange& candidate,
                                               const ChangeTest::Explained& explained,
                                               const FreeFit& fit) {
  std::vector<ParameterChange> changes;
  if (candidate.kind == ChangeKind::place) {
    static constexpr const char* kNames[] = {"rx", "ry", "rz", "tx", "ty", "tz"};
    for (Index i = 0; i < 6; ++i)
      changes.push_back({kNames[i], 0, explained.coefficients[i],
                         std::sqrt(std::max(0.0, explained.covariance(i, i)))});
    return changes;
  }
  const RigLayout layout(fit.state, fit.connected);
  const Bundle& bundle = fit.state.cameras[candidate.camera];
  for (std::size_t i = 0; i < bundle.free_values.size(); ++i) {
    const Eigen::RowVectorXd row =
        candidate.basis.row(layout.lens[candidate.camera] + static_cast<Index>(i));
    if (row.isZero()) continue;
    const double variance = row.dot(row * explained.covariance);
    changes.push_back({std::string(bundle.model->free()[i].name),
                       bundle.known_lens->values[static_cast<Index>(i)],
                       row.dot(explained.coefficients.transpose()),
                       std::sqrt(std::max(0.0, variance))});
  }
  return changes;
}

// True if a candidate can change all that another one can.
bool contains(const PossibleChange& all, const PossibleChange& part) {
  const MatrixXd rest = all.basis * all.basis.colPivHouseholderQr().solve(part.basis) - part.basis;
  return rest.norm() < 1e-9 * part.basis.norm();  // numeric: rounding
}

}  // namespace

std::vector<PossibleChange> candidates_of(const FreeFit& fit, Index size) {
  return Candidates(fit, size).all();
}

std::optional<CameraChange> leanest_change(const std::vector<PossibleChange>& candidates,
                                           const ChangeTest& test, const FreeFit& fit) {
  const PossibleChange* best = nullptr;
  ChangeTest::Explained of_best;
  for (const PossibleChange& candidate : candidates) {
    if (best && candidate.basis.cols() > best->basis.cols()) break;
    ChangeTest::Explained explained = test.explained_by(candidate.basis);
    if (test.rest(explained) > policy::kCheckQuantile) continue;
    if (best && explained.square <= of_best.square) continue;
    best = &candidate;
    of_best = std::move(explained);
  }
  if (!best) return std::nullopt;
  const auto [rms, most] = lengths(best->pixels * of_best.coefficients);
  CameraChange change{best->camera, best->kind, parameter_changes(*best, of_best, fit),
                      rms,          most,       {}};
  for (const PossibleChange& other : candidates)
    if (!contains(other, *best) &&
        test.rest(test.explained_by(other.basis)) <= policy::kCheckQuantile)
      change.as_well.push_back({other.camera, other.kind});
  return change;
}

DetectableChange detectable(const PossibleChange& candidate, const ChangeTest& test,
                            const FreeFit& fit) {
  const VectorXd least = test.least_shown(candidate.basis, candidate.pixels);
  DetectableChange change{candidate.camera,
                          candidate.kind,
                          lengths(candidate.pixels * least).second,
                          without_scale(candidate, least, fit),
                          0,
                          {}};
  constexpr double kMillimetres = 1000;  // of a metre
  if (candidate.kind == ChangeKind::focal_length) {
    const Lens lens = fit.state.cameras[candidate.camera].lens();
    change.size = std::abs(least[0]) * parameters(lens)[0];
  }
  if (candidate.kind == ChangeKind::principal_point) change.size = least.norm();
  if (candidate.kind == ChangeKind::place) {
    change.size = kMillimetres * least.tail<3>().norm();
    change.step.assign(least.begin(), least.end());
  } else {
    const VectorXd all = candidate.basis * least;
    const RigLayout layout(fit.state, fit.connected);
    const auto of_lens = all.segment(layout.lens[candidate.camera],
                                     fit.state.cameras[candidate.camera].model->num_free());
    change.step.assign(of_lens.begin(), of_lens.end());
  }
  return change;
}

}  // namespace tagcal::internal
