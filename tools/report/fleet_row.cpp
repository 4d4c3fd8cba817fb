#include "report/fleet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

std::string free_names(const Model& model) {
  return internal::joined(model.free(), " ", &FreeParameter::name);
}

void set_camera(FleetRow& row, const UncertainCamera& known) {
  row.lens = kind_of(known.camera.lens).name;
  row.image_size = known.camera.image_size;
  if (known.model == nullptr || known.covariance.size() == 0) {
    row.reason = "has no covariance";
    return;
  }
  row.model = known.model->name();
  row.names = free_names(*known.model);
  row.known = {known.model->free_values(known.camera.lens), known.covariance};
}

// Numbers with blanks between them: a list of JSON takes five times as long to read.
std::string numbers_text(const std::vector<double>& values) {
  return fmt::format("{}", fmt::join(values, " "));
}

std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    const auto [stop, error] = std::from_chars(at, end, values.emplace_back());
    if (error != std::errc()) throw Error("no number");
    at = stop + (stop < end ? 1 : 0);
  }
  return values;
}

// The lower triangle, row by row.
std::string triangle_text(const MatrixX& matrix) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) values.push_back(matrix(i, j));
  return numbers_text(values);
}

MatrixX matrix_of(const std::vector<double>& triangle, std::size_t size) {
  const auto n = static_cast<Eigen::Index>(size);
  MatrixX matrix(n, n);
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = triangle.at(at++);
  return matrix;
}

FleetRow row_of(const nlohmann::json& json) {
  FleetRow row;
  row.status = json.at("status");
  row.reason = json.at("reason");
  row.lens = json.at("lens");
  row.model = json.at("model");
  row.names = json.at("names");
  row.image_size = {json.at("image_size").at(0), json.at("image_size").at(1)};
  row.rms_px = json.at("rms_px");
  row.known.values = numbers_of(json.at("values").get_ref<const std::string&>());
  row.known.covariance = matrix_of(numbers_of(json.at("covariance").get_ref<const std::string&>()),
                                   row.known.values.size());
  return row;
}

}  // namespace

const Model* model_of(const FleetRow& row) {
  const auto models = Model::all();
  const auto model = std::ranges::find(models, row.model, &Model::name);
  return model != models.end() && free_names(*model) == row.names ? &*model : nullptr;
}

FleetRow fleet_row(const std::string& name, const Calibration& calibration) {
  FleetRow row;
  row.name = name;
  row.status = status_name(calibration.status);
  if (is_answer(calibration.status)) {
    set_camera(row, uncertain_camera(calibration));
    row.rms_px = calibration.rms_px;
    return row;
  }
  const auto refusal = std::ranges::find_if(calibration.findings, is_refusal);
  if (refusal != calibration.findings.end()) row.reason = refusal->sentence;
  return row;
}

FleetRow fleet_row(const std::string& name, const CalibrationFile& file) {
  FleetRow row;
  row.name = name;
  row.status = status_name(Status::ok);
  set_camera(row, uncertain_camera(file));
  return row;
}

nlohmann::json fleet_row_json(const FleetRow& row) {
  return {{"status", row.status},
          {"reason", row.reason},
          {"lens", row.lens},
          {"model", row.model},
          {"names", row.names},
          {"image_size", {row.image_size.width, row.image_size.height}},
          {"rms_px", row.rms_px},
          {"values", numbers_text(row.known.values)},
          {"covariance", triangle_text(row.known.covariance)}};
}

FleetRow read_summary(const std::filesystem::path& file) {
  FleetRow row;
  try {
    const nlohmann::json kept = nlohmann::json::parse(read_text(file));
    row = row_of(kept.at("unit"));
    row.made_by = kept.at("made_by");
  } catch (const std::exception&) {
    row.status = "error";
    row.reason = fmt::format("{}: is damaged; calibrate it again", file.string());
  }
  row.name = file.stem().string();
  return row;
}

}  // namespace tagcal::tools
