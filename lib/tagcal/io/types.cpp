#include "tagcal/io/types.hpp"

#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal {

UncertainCamera uncertain_camera(const Calibration& calibration) {
  if (calibration.claim) return *calibration.claim;
  return {nullptr, *calibration.camera, {}};
}

UncertainCamera uncertain_camera(const CalibrationFile& file) {
  if (file.claim_covariance.size() > 0)
    return {&Model::named(file.claim_model), file.camera, file.claim_covariance};
  if (file.covariance.size() == 0) return {nullptr, file.camera, {}};
  const HeldModels models(file.fixed, Model::named(file.model).kind());
  const Model& held = models.named(file.model);
  const Model& free = Model::named(held.name());
  return {&free, file.camera, covariance_by(free, {&held, file.camera, file.covariance})};
}

}  // namespace tagcal
