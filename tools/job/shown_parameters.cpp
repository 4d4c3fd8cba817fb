#include "job/shown_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "tagcal/camera/model.hpp"

namespace tagcal::tools {
namespace {

bool is_free(const Model& model, int lens_parameter) {
  return std::any_of(model.free().begin(), model.free().end(), [&](const FreeParameter& free) {
    const auto& of = free.lens_parameters;
    return std::find(of.begin(), of.end(), lens_parameter) != of.end();
  });
}

}  // namespace

std::vector<Shown> shown_parameters(const Calibration& calibration) {
  const Lens& lens = calibration.camera->lens;
  const std::span<const double> values = parameters(lens);
  const HeldModels models(calibration.fixed, Model::named(calibration.model).kind());
  const Model& model = models.named(calibration.model);
  const bool parallel = !kind_of(lens).is_central;
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < values.size(); ++i) {
    Shown parameter;
    const bool free = is_free(model, static_cast<int>(i));
    const bool scale_of_a_view = parallel && i < 2;  // sx, sy: every view has its own
    parameter.name = scale_of_a_view ? Perspective::kParameters[i].name : parameter_names(lens)[i];
    if (!scale_of_a_view && (!free || is_answer(calibration.status))) {
      parameter.value = values[i];
      if (i < calibration.sigmas.size()) parameter.sigma = calibration.sigmas[i];
      if (!free) parameter.sigma = 0;
    }
    shown.push_back(parameter);
  }
  return shown;
}

std::size_t num_shown(const Calibration& calibration) {
  const std::size_t all = parameters(calibration.camera->lens).size();
  const Lens& lens = calibration.camera->lens;
  if (!kind_of(lens).is_central) return all - 2;  // a calibrated one is not oblique
  const Model& model = Model::named(calibration.model);
  if (model.role() == ModelRole::largest) return all;
  return static_cast<std::size_t>(model.sibling(model.kind(), ModelRole::usual).num_free());
}

double largest_px(const ProjectionUncertainty& projection) {
  double value = 0;
  for (const double sigma : projection.sigma_px.reshaped())
    if (sigma > value) value = sigma;
  return value;
}

int nodes_without_ray(const ProjectionUncertainty& projection) {
  return static_cast<int>(projection.sigma_px.array().isNaN().count());
}

bool has_bound(double sigma_px, const ImageSize& size) {
  return sigma_px <= std::hypot(size.width, size.height);
}

}  // namespace tagcal::tools
