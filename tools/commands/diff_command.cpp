#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/diff_rigs.hpp"
#include "draw/heat_map.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "report/json_parts.hpp"
#include "report/lens_comparison.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector2d;

using internal::kDegree;

struct DiffArguments {
  std::string a;
  std::string b;
  double near_m = 1;
  double limit_px = 0;  // 0: not given
  bool whole_image = false;
  bool json = false;
};

double at(const LensDifference& d, int row, int column) {
  return std::hypot(d.u_px(row, column), d.v_px(row, column));
}

// Largest difference over the nodes, and the number of nodes without a value.
struct WholeImage {
  double max_px = 0;
  int without_value = 0;
};

WholeImage whole_image(const LensDifference& d) {
  WholeImage whole;
  for (int row = 0; row < d.grid.rows; ++row) {
    for (int column = 0; column < d.grid.columns; ++column) {
      const double length = at(d, row, column);
      if (std::isfinite(length))
        whole.max_px = std::max(whole.max_px, length);
      else
        ++whole.without_value;
    }
  }
  return whole;
}

Json grid_json(const LensDifference& d) {
  Json rows = Json::array();
  for (int row = 0; row < d.grid.rows; ++row) {
    Json list = Json::array();
    for (int column = 0; column < d.grid.columns; ++column) list.push_back(at(d, row, column));
    rows.push_back(std::move(list));
  }
  return rows;  // NaN becomes null
}

// Without the sign of a zero.
std::string three_numbers(const Eigen::Vector3d& values, int decimals) {
  const double step = std::pow(10.0, -decimals);
  std::string text;
  for (const double value : values) {
    const double shown = std::abs(value) < step / 2 ? 0 : value;
    text += fmt::format("{}{:.{}f}", text.empty() ? "" : " ", shown, decimals);
  }
  return text;
}

Json difference_json(const Comparison& comparison) {
  const LensDifference& d = comparison.difference;
  const Eigen::Vector3d turn = log_rotation(d.b_from_a.rotation()) / kDegree;
  const Eigen::Vector3d& move = d.b_from_a.translation();
  const WholeImage whole = whole_image(d);
  return {{"distance_m", distance_json(d.distance_m)},
          {"rms_px", d.rms_px},
          {"max_px", d.max_px},
          {"expected_px", comparison.test ? Json(comparison.test->expected_px) : Json()},
          {"in_sigmas", comparison.test ? Json(comparison.test->in_sigmas) : Json()},
          {"whole_image_max_px", whole.max_px},
          {"nodes_without_value", whole.without_value},
          {"rotation_deg", {turn.x(), turn.y(), turn.z()}},
          {"translation_m", {move.x(), move.y(), move.z()}},
          {"difference_px", grid_json(d)}};
}

// `where`: name of the region of the samples, 18 characters.
std::string difference_text(const LensDifference& d, const char* where) {
  const Eigen::Vector3d turn = log_rotation(d.b_from_a.rotation()) / kDegree;
  const Eigen::Vector3d move = 1000 * d.b_from_a.translation();
  const WholeImage whole = whole_image(d);
  std::string text = fmt::format("at {}\n  {}  {:.4f} px rms, {:.4f} px at most\n",
                                 distance_text(d.distance_m), where, d.rms_px, d.max_px);
  text += fmt::format("  whole image         {:.4f} px at most{}\n", whole.max_px,
                      whole.without_value == 0
                          ? ""
                          : fmt::format(", {} of {} nodes without a value", whole.without_value,
                                        d.grid.rows * d.grid.columns));
  text += "  taken out           turn " + three_numbers(turn, 4) + " deg";
  if (std::isfinite(d.distance_m)) text += ", move " + three_numbers(move, 3) + " mm";
  text += "\n";
  for (int row = 0; row < d.grid.rows; row += 3) {
    text += "   ";
    for (int column = 0; column < d.grid.columns; column += 4)
      text += std::isfinite(at(d, row, column)) ? fmt::format("{:>9.3f}", at(d, row, column))
                                                : fmt::format("{:>9}", "none");
    text += "\n";
  }
  return text;
}

// True if both arguments are rigs. Throws Error if one is.
bool is_of_rigs(const DiffArguments& arguments, const std::optional<ComparedRig>& a,
                const std::optional<ComparedRig>& b) {
  if (a.has_value() != b.has_value()) {
    const std::string& rig = a ? arguments.a : arguments.b;
    throw Error(fmt::format("{}: must be a rig as {} is, or take one camera of that: {}:{}",
                            a ? arguments.b : arguments.a, rig, rig,
                            (a ? a : b)->file.cameras.front().name));
  }
  return a.has_value();
}

// With a limit the comparison is a check.
int exit_code(const DiffArguments& arguments, const std::optional<CheckVerdict>& verdict) {
  if (arguments.limit_px == 0 || verdict == CheckVerdict::valid) return kAnswer;
  return verdict == CheckVerdict::changed ? kCheckFailed : kNoAnswer;
}

int run(const DiffArguments& arguments) {
  constexpr double kUsualLimitPx = 1;  // numeric: the default in the manual
  const double limit_px = arguments.limit_px > 0 ? arguments.limit_px : kUsualLimitPx;
  const std::optional<ComparedRig> rig_a = rig_of_argument(arguments.a),
                                   rig_b = rig_of_argument(arguments.b);
  if (is_of_rigs(arguments, rig_a, rig_b)) {
    const RigDifferenceAnswer answer = rig_difference(
        *rig_a, *rig_b, arguments.near_m, arguments.whole_image, limit_px, arguments.json);
    print_answer(answer.text, arguments.json);
    return exit_code(arguments, answer.verdict);
  }
  const CalibrationFile a = read_camera(arguments.a);
  const CalibrationFile b = read_camera(arguments.b);
  const std::vector<Vector2d> samples =
      arguments.whole_image ? ImageGrid{a.camera.image_size, 33, 21}.pixels() : common_region(a, b);
  const bool region_known = !a.seen.hull().empty() || !b.seen.hull().empty();
  const char* const where =
      region_known && !arguments.whole_image ? "where corners were" : "over all the image";
  const std::vector<Comparison> comparisons =
      compare(arguments.a, arguments.b, samples, std::array{kInfinitelyFar, arguments.near_m});
  Json list = Json::array();
  std::string text;
  for (const Comparison& comparison : comparisons) {
    list.push_back(difference_json(comparison));
    text += difference_text(comparison.difference, where);
  }
  const ComparisonVerdict verdict = verdict_of(comparisons, limit_px);
  const bool is_bounded = verdict.verdict && std::isfinite(verdict.smallest_px);
  const Json answer = {{"a", arguments.a},
                       {"b", arguments.b},
                       {"verdict", verdict.verdict ? Json(verdict_name(*verdict.verdict)) : Json()},
                       {"smallest_px", is_bounded ? Json(verdict.smallest_px) : Json()},
                       {"differences", list}};
  print_answer(arguments.json ? json_text(answer) : text + verdict_text(verdict), arguments.json);
  return exit_code(arguments, verdict.verdict);
}

}  // namespace

Command add_diff(CLI::App& app) {
  CLI::App* command = add_command(
      app, "diff",
      "compares two calibrations in pixels, after removing a camera motion; or two rigs");
  const auto arguments = std::make_shared<DiffArguments>();
  add_option(*command, "A", arguments->a, "a calibration, or a rig").required();
  add_option(*command, "B", arguments->b, "another of the same image size, or of the same rig")
      .required();
  add_length(*command, "--distance", arguments->near_m,
             "distance in metres at which they are compared, beside infinity (1)");
  add_positive(*command, "--limit", arguments->limit_px,
               "the change that matters, px in the image (1): valid only if a smaller one would "
               "have been seen; the exit code is then that of a check");
  add_flag(*command, "--whole-image", arguments->whole_image,
           "fit the moved camera over the whole image, not only where both had corners");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_footer(*command,
             "Example: tagcal diff monday.yaml friday.yaml --distance 2\n"
             "         tagcal diff rig_monday.yaml rig_friday.yaml");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
