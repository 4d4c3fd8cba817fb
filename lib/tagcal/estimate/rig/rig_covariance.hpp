#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/rig/rig_state.hpp"

namespace tagcal::internal {

// The place of the parameters of a rig in one vector: the extrinsics of each connected camera but
// the reference (six each), the free parameters of each lens, the shape of the board.
struct RigLayout {
  std::vector<std::optional<Eigen::Index>> pose;  // by camera
  std::vector<Eigen::Index> lens;                 // by camera
  std::optional<Eigen::Index> shape;
  Eigen::Index size = 0;

  RigLayout(const RigState& state, const std::vector<std::uint8_t>& is_connected);
};

// The information of a solved rig. An instant is one sample, because its views share the pose of
// the boards. No value if a view does not determine its pose.
std::optional<BundleInformation> rig_information(const RigState& solved, const RigLayout& layout);

// The overdispersion that neighbouring residuals suggest: that of the worst camera.
double overdispersion_of_rig(const RigState& solved);

// The positive part of the difference of two covariances of the same parameters.
Eigen::MatrixXd excess_of(const Eigen::MatrixXd& claim, const Eigen::MatrixXd& own);

// Adds the covariance of an error of one lens, by the free parameters of its bundle's model, and
// its effect on the extrinsics: their response is -H_ee^-1 H_el, with `information` H.
void add_claim(Eigen::MatrixXd& covariance, const RigLayout& layout,
               const Eigen::MatrixXd& information, std::size_t camera,
               const Eigen::MatrixXd& excess);

}  // namespace tagcal::internal
