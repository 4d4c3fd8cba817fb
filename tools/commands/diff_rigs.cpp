#include "commands/diff_rigs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "draw/heat_map.hpp"
#include "job/camera_input.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "report/json_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {
namespace {

using RigJson = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr double kDegrees = internal::degrees(1);
constexpr double kLeastStep = 1e-12;  // numeric: rad or m; smaller differences are shown as 0

// The lenses of a camera that both rigs have.
struct ComparedLens {
  std::string name;
  std::vector<Comparison> comparisons;
};

struct RigDifference {
  std::vector<std::string> only_in_a, only_in_b;
  std::vector<ComparedLens> lenses;
  PlacesComparison places;
  std::vector<std::string> names;  // of the shared cameras, as rig A has them
};

std::vector<std::string> names_without(const ComparedRig& rig, std::span<const SharedCamera> shared,
                                       std::size_t SharedCamera::*number) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < rig.file.cameras.size(); ++i)
    if (std::ranges::find(shared, i, number) == shared.end())
      names.push_back(rig.file.cameras[i].name);
  return names;
}

RigDifference difference_of_rigs(const ComparedRig& a, const ComparedRig& b, double near_m,
                                 bool whole_image) {
  const std::vector<SharedCamera> shared = shared_cameras(a, b);
  RigDifference difference{names_without(a, shared, &SharedCamera::in_a),
                           names_without(b, shared, &SharedCamera::in_b),
                           {},
                           compare_places(a, b, shared),
                           {}};
  for (const SharedCamera& s : shared) {
    const FileCamera &of_a = a.file.cameras[s.in_a], &of_b = b.file.cameras[s.in_b];
    const std::vector<Eigen::Vector2d> samples =
        whole_image ? ImageGrid{of_a.calibration.camera.image_size, 33, 21}.pixels()
                    : common_region(of_a.calibration, of_b.calibration);
    difference.names.push_back(of_a.name);
    difference.lenses.push_back(
        {of_a.name == of_b.name ? of_a.name : of_a.name + ", " + of_b.name,
         compare(a.name + ":" + of_a.name, a.rig.cameras[s.in_a].camera, b.name + ":" + of_b.name,
                 b.rig.cameras[s.in_b].camera, samples, std::array{kInfinitelyFar, near_m})});
  }
  return difference;
}

// What differs by more than the covariances explain: "lens of left", "places".
std::vector<std::string> differing(const RigDifference& difference) {
  std::vector<std::string> parts;
  for (const ComparedLens& lens : difference.lenses)
    if (verdict_of(lens.comparisons).verdict == CheckVerdict::changed)
      parts.push_back("the lens of " + lens.name);
  const std::optional<double>& places = difference.places.in_sigmas;
  if (places && change_verdict(*places, 0, 0) == CheckVerdict::changed) {
    const auto worst = std::ranges::max_element(
        difference.places.pairs, {},
        [](const PlaceDifference& pair) { return pair.in_sigmas.value_or(0); });
    parts.push_back(fmt::format("the place of {} from {}", difference.names[worst->second],
                                difference.names[worst->first]));
  }
  return parts;
}

bool is_known(const RigDifference& difference) {
  return difference.places.in_sigmas ||
         std::ranges::any_of(difference.lenses, [](const ComparedLens& lens) {
           return worst_of(lens.comparisons) != nullptr;
         });
}

// As of two cameras: of the lens that could hide the largest change, unless something changed.
ComparisonVerdict rigs_verdict(const RigDifference& difference, double limit_px) {
  if (!is_known(difference))
    return {std::nullopt, "", "not known if they are one rig: neither file has a covariance", 0};
  ComparisonVerdict verdict{CheckVerdict::valid, "VALID", "", 0};
  for (const ComparedLens& lens : difference.lenses)
    if (ComparisonVerdict of_lens = verdict_of(lens.comparisons, limit_px);
        of_lens.verdict && of_lens.smallest_px >= verdict.smallest_px) {
      verdict = std::move(of_lens);
      verdict.sentence = fmt::format("{}: {}", lens.name, verdict.sentence);
    }
  if (!difference.places.in_sigmas)
    verdict.sentence += "; of the places neither file has a covariance";
  else if (verdict.sentence.empty())
    verdict.sentence = "the places differ by no more than the covariances explain";
  const std::vector<std::string> parts = differing(difference);
  if (parts.empty()) return verdict;
  return {CheckVerdict::changed, "CHANGED",
          fmt::format("{} differ{} by more than the covariances explain", fmt::join(parts, ", "),
                      parts.size() == 1 ? "s" : ""),
          verdict.smallest_px};
}

double without_rounding(double value, double least) { return std::abs(value) < least ? 0 : value; }

std::string sd_text(const std::optional<double>& in_sigmas) {
  return in_sigmas ? fmt::format(", {:.1f} sd", *in_sigmas) : "";
}

std::string lens_lines(const ComparedLens& lens) {
  std::string text = lens.name + "\n";
  for (const Comparison& c : lens.comparisons) {
    const std::optional<double> score =
        c.test ? std::optional(c.test->in_sigmas) : std::optional<double>();
    text += fmt::format(
        "  lens at {:<12} {} px rms, {} px at most{}\n", distance_text(c.difference.distance_m),
        two_digits(without_rounding(c.difference.rms_px, kLeastPx)),
        two_digits(without_rounding(c.difference.max_px, kLeastPx)), sd_text(score));
  }
  return text;
}

// Three values with their standard deviations, from `first` of (omega, tau) on.
std::string three_steps(const PlaceDifference& pair, int first, double unit) {
  std::string text;
  for (int i = first; i < first + 3; ++i) {
    const double sigma =
        pair.covariance ? std::sqrt(std::max(0.0, (*pair.covariance)(i, i))) : std::nan("");
    const double step = without_rounding(pair.step[i], kLeastStep);
    text += fmt::format("  {:>20}", with_sigma(unit * step, unit * sigma));
  }
  return text;
}

std::string pair_lines_of(const PlaceDifference& pair, const RigDifference& difference) {
  return fmt::format(
      "{} - {}: baseline {:.4f} and {:.4f} mm{}\n  translation mm {}\n  rotation deg   {}\n",
      difference.names[pair.first], difference.names[pair.second],
      1e3 * pair.a.translation().norm(), 1e3 * pair.b.translation().norm(), sd_text(pair.in_sigmas),
      three_steps(pair, 3, 1e3), three_steps(pair, 0, kDegrees));
}

std::string rigs_text(const RigDifference& difference, const std::string& a, const std::string& b,
                      double limit_px) {
  std::string text;
  for (const ComparedLens& lens : difference.lenses) text += lens_lines(lens);
  text += "\nplaces, B less A\n";
  for (const PlaceDifference& pair : difference.places.pairs)
    text += pair_lines_of(pair, difference);
  if (difference.places.in_sigmas && difference.places.pairs.size() > 1)
    text += fmt::format("all places together{}\n", sd_text(difference.places.in_sigmas));
  for (const auto& [names, file] :
       {std::pair(&difference.only_in_a, a), {&difference.only_in_b, b}})
    if (!names->empty()) text += fmt::format("only in {}: {}\n", file, fmt::join(*names, ", "));
  return text + "\n" + verdict_text(rigs_verdict(difference, limit_px));
}

RigJson three_json(const Vector6d& values, int first, double unit) {
  return {unit * values[first], unit * values[first + 1], unit * values[first + 2]};
}

RigJson pair_json_of(const PlaceDifference& pair, const RigDifference& difference) {
  RigJson json = {{"a", difference.names[pair.first]},
                  {"b", difference.names[pair.second]},
                  {"baseline_m", {pair.a.translation().norm(), pair.b.translation().norm()}},
                  {"rotation_deg", three_json(pair.step, 0, kDegrees)},
                  {"translation_m", three_json(pair.step, 3, 1)},
                  {"rotation_sigma_deg", RigJson()},
                  {"translation_sigma_m", RigJson()},
                  {"in_sigmas", optional_json(pair.in_sigmas)}};
  if (!pair.covariance) return json;
  const Vector6d sigmas = pair.covariance->diagonal().cwiseMax(0).cwiseSqrt();
  json["rotation_sigma_deg"] = three_json(sigmas, 0, kDegrees);
  json["translation_sigma_m"] = three_json(sigmas, 3, 1);
  return json;
}

RigJson rigs_json(const RigDifference& difference, const std::string& a, const std::string& b,
                  double limit_px) {
  RigJson cameras = RigJson::array(), pairs = RigJson::array();
  for (std::size_t i = 0; i < difference.lenses.size(); ++i) {
    RigJson list = RigJson::array();
    for (const Comparison& c : difference.lenses[i].comparisons) {
      list.push_back({{"distance_m", distance_json(c.difference.distance_m)},
                      {"rms_px", c.difference.rms_px},
                      {"max_px", c.difference.max_px},
                      {"expected_px", c.test ? RigJson(c.test->expected_px) : RigJson()},
                      {"in_sigmas", c.test ? RigJson(c.test->in_sigmas) : RigJson()}});
    }
    cameras.push_back({{"name", difference.names[i]}, {"differences", list}});
  }
  for (const PlaceDifference& pair : difference.places.pairs)
    pairs.push_back(pair_json_of(pair, difference));
  const ComparisonVerdict verdict = rigs_verdict(difference, limit_px);
  return {{"a", a},
          {"b", b},
          {"cameras", cameras},
          {"pairs", pairs},
          {"only_in_a", difference.only_in_a},
          {"only_in_b", difference.only_in_b},
          {"places_in_sigmas", optional_json(difference.places.in_sigmas)},
          {"verdict", verdict.verdict ? RigJson(verdict_name(*verdict.verdict)) : RigJson()},
          {"differs_in", differing(difference)}};
}

}  // namespace

std::optional<ComparedRig> rig_of_argument(const std::string& file_and_name) {
  std::error_code error;
  if (!std::filesystem::exists(file_and_name, error)) return std::nullopt;
  const CameraFile file = read_camera_file(file_and_name);
  if (file.cameras.size() < 2) return std::nullopt;
  hold_notes(file_and_name, file.notes);
  return compared_rig(file_and_name, file);
}

RigDifferenceAnswer rig_difference(const ComparedRig& a, const ComparedRig& b, double near_m,
                                   bool whole_image, double limit_px, bool as_json) {
  const RigDifference difference = difference_of_rigs(a, b, near_m, whole_image);
  return {as_json ? json_text(rigs_json(difference, a.name, b.name, limit_px))
                  : rigs_text(difference, a.name, b.name, limit_px),
          rigs_verdict(difference, limit_px).verdict};
}

}  // namespace tagcal::tools
