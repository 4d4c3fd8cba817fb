#include "page_data/pages.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "job/camera_input.hpp"
#include "page_data/page_parts.hpp"
#include "report/lens_comparison.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector3d;

using internal::kDegree;

PageJson vector_json(const Vector3d& v) {
  return {significant(v.x()), significant(v.y()), significant(v.z())};
}

PageJson map_json(const Comparison& comparison) {
  const LensDifference& d = comparison.difference;
  const auto& test = comparison.test;
  return {{"distance_m", significant(d.distance_m, 3)},
          {"columns", d.grid.columns},
          {"rows", d.grid.rows},
          {"u_px", grid_json(d.u_px)},
          {"v_px", grid_json(d.v_px)},
          {"rms_px", significant(d.rms_px)},
          {"max_px", significant(d.max_px)},
          {"expected_px", test ? significant(test->expected_px) : PageJson()},
          {"p_value", test ? significant(std::erfc(test->in_sigmas / std::numbers::sqrt2) / 2, 3)
                           : PageJson()},
          {"rotation_deg", vector_json(log_rotation(d.b_from_a.rotation()) / kDegree)},
          {"translation_m", vector_json(d.b_from_a.translation())}};
}

// The parameters that both lenses have, by name.
PageJson common_parameters_json(const CalibrationFile& a, const CalibrationFile& b) {
  PageJson list = PageJson::array();
  const auto names_a = parameter_names(a.camera.lens), names_b = parameter_names(b.camera.lens);
  if (a.camera.lens.index() != b.camera.lens.index()) return list;
  for (std::size_t i = 0; i < names_a.size() && i < names_b.size(); ++i) {
    const double value_a = parameters(a.camera.lens)[i], value_b = parameters(b.camera.lens)[i];
    if (value_a == 0 && value_b == 0) continue;
    const auto sigma_of = [i](const CalibrationFile& file) {
      return i < file.sigmas.size() ? file.sigmas[i] : std::nan("");
    };
    const double sigma = std::hypot(sigma_of(a), sigma_of(b));
    list.push_back({{"name", names_a[i]},
                    {"a", significant(value_a, 10)},
                    {"b", significant(value_b, 10)},
                    {"sigma_a", significant(sigma_of(a))},
                    {"sigma_b", significant(sigma_of(b))},
                    {"in_sigmas", significant((value_b - value_a) / sigma)}});
  }
  return list;
}

std::string level_of(const ComparisonVerdict& verdict) {
  return verdict.verdict == CheckVerdict::valid ? "ok" : "warnings";
}

// Two files of one name are told apart by their folders.
std::string title_of(const std::string& file_a, const std::string& file_b) {
  const std::string a = last_part(file_a), b = last_part(file_b);
  return a == b ? fmt::format("{} and {}", file_a, file_b) : fmt::format("{} and {}", a, b);
}

}  // namespace

PageJson difference_page(const std::string& file_a, const std::string& file_b, double near_m) {
  const CalibrationFile a = read_camera(file_a), b = read_camera(file_b);
  const std::vector<Comparison> comparisons =
      compare(file_a, file_b, common_region(a, b), std::array{near_m, kInfinitelyFar});
  const ComparisonVerdict verdict = verdict_of(comparisons);
  PageJson maps = PageJson::array();
  for (const Comparison& comparison : comparisons) maps.push_back(map_json(comparison));
  std::vector<std::string> notes;
  for (const auto& [name, file] : {std::pair{&file_a, &a}, std::pair{&file_b, &b}})
    if (file->covariance.size() == 0)
      notes.push_back(fmt::format("{} has no covariance: it is taken as exact.", *name));
  const PageJson judged = {
      {"level", level_of(verdict)},
      {"sentence",
       verdict.word.empty() ? verdict.sentence : verdict.word + ": " + verdict.sentence}};
  return {{"format", 1},
          {"kind", "difference"},
          {"title", title_of(file_a, file_b)},
          {"verdict", judged},
          {"made_by", made_by_json()},
          {"notes", notes},
          {"findings", PageJson::array()},
          {"image_size", {a.camera.image_size.width, a.camera.image_size.height}},
          {"difference",
           {{"a", file_a},
            {"b", file_b},
            {"verdict", judged},
            {"maps", std::move(maps)},
            {"parameters", common_parameters_json(a, b)}}}};
}

}  // namespace tagcal::tools
