#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/estimate/types.hpp"

// A lens of one model that projects as a lens of another does, in the same camera frame: poses and
// pixels keep their meaning.

namespace tagcal {

// The lens to describe by another model, and what is known about it.
struct LensFitSource {
  Camera camera = {pinhole(1, 1, 0, 0), {}};
  // The covariance (k x k) of these parameters of camera.lens. Empty: the lens is taken as exact.
  std::vector<FreeParameter> free;
  MatrixX covariance;
  SeenRegion seen;  // where the lens is known; empty: the whole image
};

struct LensFitOptions {
  // Largest difference of the projections over the region that is accepted; 0: 0.1 px.
  double max_difference_px = 0;
};

// The pixel by the fitted lens minus that by the source, over pixels where the source has a ray.
struct LensFitDifference {
  double max_px = 0;         // the largest |difference|
  double rms_px = 0;         // sqrt(mean |difference|^2)
  double share_without = 0;  // of these pixels: the fitted lens has no projection there
};

struct LensFit {
  const Model* model = nullptr;  // that of the fitted lens, not owned
  Camera camera;
  MatrixX covariance;  // of the free parameters of `model`; empty without that of the source
  std::vector<double> sigmas;  // of each lens parameter, 0 for a held one; empty like covariance
  LensFitDifference seen;      // over the region
  LensFitDifference image;     // over the whole image
  ImageGrid grid;
  // |difference| at the nodes (rows x columns); NaN where the source has no ray, infinite where the
  // fitted lens has no projection.
  MatrixX difference_px;
  // Why the lens does not replace the source: a sentence. No value if it does.
  std::optional<std::string> refusal;
};

// The free parameters q of the model that minimise the sum of |project_q(ray) - pixel|^2 over the
// pixels of a grid in the region and of its border, with the rays of the source
// (Levenberg-Marquardt; from the source's own parameters if its lens is of the same type, from a
// linear solution, and from a lens without distortion: the best). A perspective is fitted to the
// rays within 80 degrees of the axis.
//
// The covariance is carried over by the implicit function theorem: with J_q and J_p the Jacobians
// of the two projections at the same rays, by the parameters of the fitted lens and of the source,
//   dq/dp = (J_q^T J_q)^-1 J_q^T J_p        cov(q) = dq/dp cov(p) (dq/dp)^T,
// to first order in the remaining differences. It has at most the rank of the source's: it says
// nothing about lenses that only the new model can describe. Combinations of q that the projection
// does not determine get the smallest of the possible changes; if the new model contains the old
// lens, the further parameters stay zero with standard deviation zero.
//
// Throws Error for a parallel lens or the model `weak`, an image without pixels, a bound that is
// not > 0, and a covariance that is not of the model.
LensFit fit_lens(const LensFitSource& source, const Model& model,
                 const LensFitOptions& options = {});

// The free parameters of a model with some parameters held at values (HeldModels).
std::vector<FreeParameter> free_parameters(std::string_view model,
                                           const std::map<std::string, double>& fixed);

}  // namespace tagcal
