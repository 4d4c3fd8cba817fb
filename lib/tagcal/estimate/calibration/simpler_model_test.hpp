#pragma once

#include <optional>

#include "tagcal/estimate/bundle/observability.hpp"

namespace tagcal::internal {

// Many free coefficients can talk the information of an estimate into a lens that the same data do
// not hold: noise makes curvature, and curvature tells of a centre and a focal length. So plain
// lenses are asked, too:
//   1. where one focal length alone explains the corners as well (by BIC), whether that is held;
//   2. where f+c or pinhole does, whether that is held, and
//   3. whether it is within the standard deviations of the estimate: the cost rises by d^2 sigma^2
//      at d of them, or they say nothing.
// What these answer where they are not; no value where there is nothing to doubt. First a few of
// the views: what these do not explain with a plain lens, all of them do not. `covariance`: of the
// free parameters of the solved bundle.
std::optional<Observability> doubt_of_plain_lens(const Bundle& solved,
                                                 const Eigen::MatrixXd& covariance, double sigma);

// Whether no corner is further than 80 degrees from the axis: a perspective lens could see it.
bool well_in_front(const Bundle& bundle);

// The same lens and poses as another model of the same lens type has them.
Bundle with_model(const Bundle& bundle, const Model& model);

// What opencv5 would explain of a solved perspective that is smaller, to first order.
struct LargerLens {
  double chi_square = 0;  // by which its sum of squares is lower, in units of sigma^2
  double share = 0;       // of the sum of squares
};

// No value for a model that is not smaller, or where the data do not hold the larger one.
std::optional<LargerLens> larger_lens(const Bundle& solved, double sigma);

}  // namespace tagcal::internal
