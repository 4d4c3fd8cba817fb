#include "tagcal/estimate/calibration/held_parameters.hpp"

#include <cmath>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

LensType lens_type(const CalibrateOptions& options) {
  return is_auto(options) ? LensType::perspective : Model::named(options.model).lens_type();
}

LensType lens_type(const Lens& lens) {
  if (std::holds_alternative<Fisheye>(lens)) return LensType::fisheye;
  return std::holds_alternative<Parallel>(lens) ? LensType::parallel : LensType::perspective;
}

const char* kind(LensType type) {
  return type == LensType::fisheye    ? "fisheye"
         : type == LensType::parallel ? "parallel lens"
                                      : "perspective";
}

}  // namespace

bool is_auto(const CalibrateOptions& options) {
  return options.model.empty() || options.model == "auto";
}

void check_start(const CalibrateOptions& options) {
  if (!std::isfinite(options.start_focal_px) || options.start_focal_px < 0)
    throw Error("start_focal_px: must be > 0, got " + std::to_string(options.start_focal_px));
  if (!options.start) return;
  if (options.start_focal_px > 0) throw Error("start: give a camera or a focal length, not both");
  const LensType type = lens_type(options.start->lens);
  if (type == LensType::parallel || (!is_auto(options) && type != lens_type(options)))
    throw Error("start: is a " + std::string(kind(type)) + ", model " +
                (is_auto(options) ? "auto" : options.model) + " needs another kind of lens");
}

void check_fixed(const CalibrateOptions& options) {
  if (options.fixed.empty()) return;
  const LensType type = lens_type(options);
  if (type == LensType::parallel)
    throw Error("fixed: model weak has no parameter that can be fixed");
  const auto models = held_models(options);
  for (const auto& [name, value] : options.fixed) {
    const ParameterKind kind = parameter_kind(name);
    const bool common =
        kind == ParameterKind::focal_length || kind == ParameterKind::principal_point;
    if (is_auto(options) && !common)
      throw Error("fixed: " + name + " needs a model by its name: auto tries several lenses");
    const bool rational = type == LensType::perspective && name >= "k4" && name <= "k6";
    if (rational && options.model != "opencv8")
      throw Error("fixed: " + name + " is a parameter of model opencv8, got " + options.model);
  }
  if (is_auto(options)) return;
  const Model& model = models->named(options.model);  // a larger one if all parameters are fixed
  if (model.num_free() == 0 || model.name() != options.model)
    throw Error("fixed: no parameter of model " + options.model + " is left to estimate");
}

std::shared_ptr<const HeldModels> held_models(const CalibrateOptions& options) {
  return std::make_shared<const HeldModels>(options.fixed, lens_type(options));
}

SeedOptions seed_options(const CalibrateOptions& options) {
  return {options.start ? &options.start->lens : nullptr, options.start_focal_px,
          !options.reject_outliers, options.num_threads};
}

}  // namespace tagcal::internal
