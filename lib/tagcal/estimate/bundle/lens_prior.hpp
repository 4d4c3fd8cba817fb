#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/camera/model.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::internal {

// Pseudo-observations of a lens, by the free parameters of a model: the cost of the prior is the
// sum of the squared residuals, in units of variance.
struct PriorRows {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd by_parameters;
};

// A deviation z from what is usual, in standard deviations, as a pseudo-observation: the residual
// of Student's t of policy::kPriorFreedom degrees of freedom, sqrt(n log(1 + z^2 / n)), because
// some lenses and boards are unlike most; and its derivative.
struct StudentResidual {
  double value = 0;
  double by_z = 1;
};
StudentResidual student_residual(double z);

// The prior of a lens (LensParameter and policy.hpp have the widths and their sources):
//   log f over the width of the image, log fy / fx, and the principal point about the centre;
//   each distortion coefficient by the share of the radius by which it moves the image's corner:
//     k_j s^p / width, with s = q / sqrt(1 + (q / kPriorLargestRadius)^2) and q = R / f for half
//     the diagonal R.
//   each shape about its plain value;
// each by its student_residual. Held parameters have no prior.
PriorRows lens_prior(const Model& model, std::span<const double> free_values,
                     const ImageSize& size);

// A centred pinhole of this focal length with the covariance that the prior gives a lens of model
// opencv5 about it; the mean of fx and fy is exact.
UncertainCamera usual_lens(double focal_px, const ImageSize& size);

}  // namespace tagcal::internal
