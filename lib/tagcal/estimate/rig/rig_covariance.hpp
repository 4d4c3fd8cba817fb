#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/rig/rig_start.hpp"

namespace tagcal::internal {

// The place of the parameters of a rig in one vector: the extrinsics of each connected camera but
// the reference (six each), the places of connected boards but the held one (six each), then the
// free parameters of each lens.
struct RigLayout {
  std::vector<std::optional<Eigen::Index>> pose;  // by camera
  std::vector<std::optional<Eigen::Index>> board;
  std::vector<Eigen::Index> lens;  // by camera
  Eigen::Index size = 0;

  RigLayout(const RigState& state, const Connected& connected);

  // The number of parameters of cameras and boards.
  Eigen::Index num_extrinsics() const { return lens.front(); }
};

// The information of a rig by its parameters and the shape of its board; an instant is one sample.
// No value if the views of an instant do not determine its pose.
std::optional<BundleInformation> rig_information(const RigState& solved, const RigLayout& layout);

// The overdispersion that neighbouring residuals suggest: that of the worst camera.
double overdispersion_of_rig(const RigState& solved);

// What is known of a lens from its own calibration, by the parameters of its bundle's model: an
// answer, and its claim, which includes the choice of the model. Empty: a lens that is exact.
struct LensClaim {
  Eigen::VectorXd answer;
  Eigen::MatrixXd covariance;
};

// The parameters of a rig whose lenses were estimated with the extrinsics, relative to its solved
// state, and their covariance.
struct RigClaim {
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;
};

// The pictures of a camera alone give its lens the information S_c and the gradient g_c; what is
// known from them is its claim, with the covariance K_c about the answer a_c. With H and G the
// information and the gradient of the rig at its state x, an instant being one sample, the rig adds
// H - diag(S_c) and G - g_c to the claims: the step d minimises
//   (d' (H - diag(S_c)) d / 2 + (G - g)' d) / phi + (x + d - a)' K^-1 (x + d - a) / 2
// and has the covariance ((H - diag(S_c)) / phi + diag(K_c^-1))^-1, with phi the overdispersion
// between the instants, or the strain of the rig (`strain_of_rig`), if that is larger. So a lens
// keeps the smaller model of its own answer where the rig does not contradict it. What the instants
// do not determine has a very large variance. No value if a view does not determine its pose.
std::optional<RigClaim> claim_of_rig(const RigState& solved, const RigLayout& layout,
                                     const std::vector<LensClaim>& claims, double strain);

// The covariance for lenses that were held: phi H_ee^-1, and the response to their errors,
// -H_ee^-1 H_el.
std::optional<Eigen::MatrixXd> covariance_of_extrinsics(const RigState& solved,
                                                        const RigLayout& layout,
                                                        const std::vector<LensClaim>& claims,
                                                        double strain);

// Adds an error of the scale of all translations, `times`: that of the board, which no picture
// shows.
void add_scale(const RigState& state, const RigLayout& layout, double times,
               Eigen::MatrixXd& covariance);

}  // namespace tagcal::internal
