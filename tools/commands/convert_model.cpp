#include "commands/convert_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>

#include "draw/canvas.hpp"
#include "draw/heat_map.hpp"
#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/lens_fit.hpp"

namespace tagcal::tools {
namespace {

LensFitSource source_of(const FileCamera& camera) {
  const CalibrationFile& known = camera.calibration;
  LensFitSource source{known.camera, {}, {}, known.seen};
  const UncertainCamera claim = uncertain_camera(known);
  if (claim.model) source.free = claim.model->free();
  source.covariance = claim.covariance;
  return source;
}

std::string lens_of(const FileCamera& camera) {
  if (!camera.calibration.model.empty()) return "lens of model " + camera.calibration.model;
  return std::string(kind_of(camera.calibration.camera.lens).name) + " lens";
}

std::string difference_line(const char* where, const LensFitDifference& d) {
  return fmt::format("  {:<20}{:.3g} px rms, {:.3g} px at most{}\n", where, d.rms_px, d.max_px,
                     d.share_without > 0
                         ? fmt::format(", no projection for {:.3g} %", 100 * d.share_without)
                         : "");
}

std::string text_of(const LensFit& fit, const FileCamera& camera) {
  std::string text =
      fmt::format("{}{}model {} for the {}; difference\n", camera.name,
                  camera.name.empty() ? "" : ": ", fit.model->name(), lens_of(camera));
  if (!camera.calibration.seen.hull().empty())
    text += difference_line("where corners were", fit.seen);
  text += difference_line("whole image", fit.image);
  const auto names = parameter_names(fit.camera.lens);
  const auto values = parameters(fit.camera.lens);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] == 0 && (fit.sigmas.empty() || fit.sigmas[i] == 0)) continue;
    text += fmt::format("  {:<8} {:>14.8g}", names[i], values[i]);
    if (!fit.sigmas.empty()) text += fmt::format(" +- {:.3g}", fit.sigmas[i]);
    text += "\n";
  }
  return text;
}

void write_picture(const std::string& file, const LensFit& fit, const SeenRegion& seen) {
  if (fit.difference_px.size() == 0) return;
  write_drawing(file, lens_fit_drawing(fit, seen));
}

// The error of the camera grows by what the lens differs, per coordinate.
void replace_lens(FileCamera& camera, const LensFit& fit) {
  CalibrationFile& known = camera.calibration;
  known.camera = fit.camera;
  known.model = fit.model->name();
  known.fixed.clear();
  known.sigmas = fit.sigmas;
  known.covariance = fit.covariance;
  known.claim_model.clear();
  known.claim_covariance.resize(0, 0);
  if (known.camera_error_px)
    known.camera_error_px = std::hypot(*known.camera_error_px, fit.seen.rms_px / std::sqrt(2.0));
}

}  // namespace

void add_model_options(CLI::App& command, ModelArguments& arguments) {
  add_option(command, "--model", arguments.model,
             fmt::format("the lens of this model that projects as the one of IN does: {}",
                         fmt::join(model_names(), ", ")))
      .one_of(model_names())
      .text("NAME");
  add_positive(command, "--max-difference-px", arguments.max_difference_px,
               "the largest difference that --model may leave over the region of the corners (the "
               "whole image, if IN has none); default 0.1")
      .text("X")
      .seldom();
  add_option(command, "--picture", arguments.picture,
             "draw the difference that --model leaves over the image (.svg, .png)")
      .text("FILE")
      .seldom();
}

void check_usage(const ModelArguments& arguments) {
  if (arguments.model.empty()) {
    if (arguments.max_difference_px > 0) throw Error("--max-difference-px: needs --model");
    if (!arguments.picture.empty()) throw Error("--picture: needs --model");
    return;
  }
  check_drawing_writable(arguments.picture);
}

bool fit_models(CameraFile& file, const std::string& name, const ModelArguments& arguments,
                const std::string& out) {
  if (arguments.model.empty()) return true;
  if (!arguments.picture.empty() && file.cameras.size() > 1)
    throw Error(fmt::format("--picture: draws one camera, {} has {}: choose one by {}:NAME", name,
                            file.cameras.size(), name));
  bool all_accepted = true;
  std::string text;
  for (FileCamera& camera : file.cameras) {
    if (camera.calibration.camera.image_size == ImageSize{})
      throw Error(fmt::format("{}: has no image size, which --model needs: --image-size", name));
    const LensFit fit =
        fit_lens(source_of(camera), Model::named(arguments.model), {arguments.max_difference_px});
    if (fit.difference_px.size() > 0) text += text_of(fit, camera);
    if (!arguments.picture.empty()) write_picture(arguments.picture, fit, camera.calibration.seen);
    if (fit.refusal) {
      print_to_stderr("{}{}{}: {}\n", name, camera.name.empty() ? "" : ":", camera.name,
                      *fit.refusal);
      all_accepted = false;
    }
    replace_lens(camera, fit);
  }
  if (!text.empty()) print_summary(text, out);
  return all_accepted;
}

}  // namespace tagcal::tools
