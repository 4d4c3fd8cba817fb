#include "tagcal/io/types.hpp"

#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal {
UncertainLens uncertain_lens(const Calibration& calibration) {
  if (calibration.claim) return *calibration.claim;
  return {nullptr, calibration.camera->lens, {}};
}

UncertainLens uncertain_lens(const CalibrationFile& file) {
  const Lens& lens = file.camera.lens;
  if (file.claim_covariance.size() > 0)
    return {&Model::named(file.claim_model), lens, file.claim_covariance};
  if (file.covariance.size() == 0) return {nullptr, lens, {}};
  const HeldModels models(file.fixed, Model::named(file.model).kind());
  const Model& held = models.named(file.model);
  const Model& free = Model::named(held.name());
  return {&free, lens, covariance_by(free, {&held, lens, file.covariance})};
}

}  // namespace tagcal
