#include "tagcal/io/formats/opencv_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/internal/text.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostTexts = 1000;  // more is no list of tagcal's; chosen by hand

// The key may be missing: the order of the values is always the same.
void check_names(const YamlValue& top, std::string_view key,
                 std::span<const std::string_view> names, std::string_view of_model) {
  const auto value = top.find(key);
  if (!value) return;
  std::vector<std::string> given;
  for (const YamlValue& item : value->items(0, kMostTexts)) given.push_back(item.text());
  if (std::ranges::equal(given, names)) return;
  value->fail_plainly(fmt::format("must be {}{}, got {}", fmt::join(names, ", "), of_model,
                                  shown(fmt::format("{}", fmt::join(given, ", ")))));
}

// Throws Error unless the standard deviations are those of the covariance, up to the rounding of
// numbers with six digits, and zero for held parameters: else one of the two is of another camera.
void check_sigmas(const YamlValue& top, const Model& model, const CalibrationFile& file) {
  constexpr double kRounding = 1e-5;  // of two numbers, relative
  const std::vector<double> expected = lens_sigmas({&model, file.camera, file.covariance});
  const std::span<const std::string_view> names = parameter_names(file.camera.lens);
  for (std::size_t k = 0; k < expected.size(); ++k)
    if (!(std::abs(file.sigmas[k] - expected[k]) <= kRounding * expected[k]))
      top.at("sigmas").fail_plainly(
          fmt::format("must be {:.6g} for {} by the covariance, got {:.6g}", expected[k], names[k],
                      file.sigmas[k]));
}

// The covariance of the free parameters of a model; `names`: the key of their names.
MatrixX covariance_of(const YamlValue& top, const YamlValue& value, const Model& model,
                      std::string_view names) {
  MatrixX covariance = read_matrix(value);
  const int n = model.num_free();
  if (covariance.rows() != n || covariance.cols() != n)
    value.fail_plainly(fmt::format("must be {0} x {0} with model {1}, got {2} x {3}", n,
                                   model.name(), covariance.rows(), covariance.cols()));
  std::vector<std::string_view> of_model;
  for (const FreeParameter& free : model.free()) of_model.push_back(free.name);
  check_names(top, names, of_model, fmt::format(" with model {}", model.name()));
  const std::string defect = covariance_defect(covariance);
  if (!defect.empty()) value.fail_plainly(defect);
  return covariance;
}

// Throws Error unless the covariance of the model is that of the claim, up to the rounding of
// numbers with six digits: else one of the two is of another camera.
void check_covariance(const YamlValue& covariance, const Model& model,
                      const CalibrationFile& file) {
  constexpr double kRounding = 1e-5;  // of two numbers, relative
  const MatrixX expected = covariance_by(model, uncertain_camera(file));
  const auto unit = [&](Eigen::Index i) {
    return std::sqrt(std::max({file.covariance(i, i), expected(i, i), 0.0}));
  };
  const auto name = [&](Eigen::Index i) { return model.free()[static_cast<std::size_t>(i)].name; };
  for (Eigen::Index i = 0; i < expected.rows(); ++i)
    for (Eigen::Index j = 0; j < expected.cols(); ++j)
      if (!(std::abs(file.covariance(i, j) - expected(i, j)) <= kRounding * unit(i) * unit(j)))
        covariance.fail_plainly(
            fmt::format("must be {:.6g} for {} and {} by claim_covariance, "
                        "got {:.6g}",
                        expected(i, j), name(i), name(j), file.covariance(i, j)));
}

void read_claim(const YamlValue& top, const YamlValue& covariance, const Model& answer,
                CalibrationFile& file) {
  const auto name = top.find("claim_model"), claim = top.find("claim_covariance");
  if (name && !claim) name->fail_plainly("needs the key claim_covariance, which is missing");
  if (!claim) return;
  if (!name) claim->fail_plainly("needs the key claim_model, which is missing");
  const Model& model = read_model(*name);
  if (&model.kind() != &answer.kind())
    name->fail_plainly(
        fmt::format("must have the kind of lens of model {}, got {}", answer.name(), model.name()));
  file.claim_model = model.name();
  file.claim_covariance = covariance_of(top, *claim, model, "claim_names");
  check_covariance(covariance, answer, file);
}

void read_covariance(const YamlValue& top, CalibrationFile& file) {
  const auto covariance = top.find("covariance");
  if (!covariance) {
    for (const char* key : {"claim_covariance", "claim_model"})
      if (const auto value = top.find(key))
        value->fail_plainly("needs the key covariance, which is missing");
    return;
  }
  if (file.model.empty()) covariance->fail_plainly("needs the key model, which is missing");
  const HeldModels models(file.fixed, Model::named(file.model).kind());
  const Model& model = models.named(file.model);
  file.covariance = covariance_of(top, *covariance, model, "covariance_names");
  if (!file.sigmas.empty()) check_sigmas(top, model, file);
  read_claim(top, *covariance, model, file);
}

// Files of other programs may mean something else by a key: only a list of texts is taken.
std::vector<std::string> texts_of(const YamlValue& top, std::string_view key) {
  std::vector<std::string> texts;
  const auto list = top.find(key);
  if (!list || !list->is_list()) return texts;
  for (const YamlValue& item : list->items(0, kMostTexts))
    if (item.is_scalar()) texts.push_back(item.text());
  return texts;
}

// Older files have the sentences only.
}  // namespace

std::vector<Finding> read_findings(const YamlValue& top) {
  std::vector<Finding> findings;
  std::vector<std::string> codes = texts_of(top, "warning_codes");
  std::vector<std::string> severities = texts_of(top, "warning_severities");
  const std::vector<std::string> sentences = texts_of(top, "warnings");
  codes.resize(sentences.size());
  severities.resize(sentences.size());
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    const bool is_note = severities[i] == severity_name(Severity::note);
    findings.push_back({codes[i], is_note ? Severity::note : Severity::warning, sentences[i]});
  }
  return findings;
}

void read_uncertainty(const YamlValue& top, CalibrationFile& file) {
  file.findings = read_findings(top);
  const std::size_t num_parameters = parameters(file.camera.lens).size();
  file.fixed = fixed_values(top);
  if (const auto sigmas = top.find("sigmas")) {
    check_names(top, "parameter_names", parameter_names(file.camera.lens), "");
    file.sigmas = read_row(*sigmas);
    if (file.sigmas.size() != num_parameters) {
      sigmas->fail_plainly(
          fmt::format("must have {} values, got {}", num_parameters, file.sigmas.size()));
    }
    for (const double sigma : file.sigmas) {
      if (sigma < 0) sigmas->fail_plainly(fmt::format("must be >= 0, got {}", sigma));
    }
  }
  read_covariance(top, file);
  if (const auto error = top.find("camera_error_px")) file.camera_error_px = error->not_negative();
  if (const auto region = top.find("seen_region")) {
    const Eigen::MatrixXd corners = read_matrix(*region);
    if (corners.rows() < 3 || corners.cols() != 2)
      region->fail_plainly(
          fmt::format("must be 3 or more x 2, got {} x {}", corners.rows(), corners.cols()));
    std::vector<Eigen::Vector2d> pixels;
    for (const auto& row : corners.rowwise()) pixels.emplace_back(row.transpose());
    file.seen = SeenRegion(file.camera.image_size, pixels);
  }
}

}  // namespace tagcal::internal
