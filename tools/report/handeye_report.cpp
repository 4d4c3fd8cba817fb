#include "report/handeye_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "job/view_values.hpp"
#include "report/findings.hpp"
#include "report/json_parts.hpp"
#include "report/rig_report.hpp"
#include "tagcal/io/handeye_file.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kWorst = 3;  // views that are shown

std::string worst_lines(const HandeyeEstimate& handeye, std::span<const HandeyeView> views) {
  std::vector<HandeyeViewFit> worst = handeye.views;
  std::ranges::sort(worst, std::ranges::greater(), &HandeyeViewFit::score);
  worst.resize(std::min(worst.size(), kWorst));
  std::string text;
  for (const HandeyeViewFit& fit : worst)
    text +=
        fmt::format("{}{}  {} mm, {} deg, {:.1f} sd\n", text.empty() ? "worst    " : "         ",
                    views[fit.view].image, two_digits(1e3 * fit.error_m),
                    two_digits(degrees(fit.error_rad)), fit.score);
  return text;
}

Json view_json(const HandeyeViewFit& fit, std::span<const HandeyeView> views) {
  return {{"image", views[fit.view].image},
          {"base_from_hand", pose_json(fit.base_from_hand)},
          {"error_m", fit.error_m},
          {"error_rad", fit.error_rad},
          {"score", fit.score},
          {"rms_px", fit.rms_px}};
}

void add_numbers(const HandeyeEstimate& handeye, Json& json) {
  json["mount_from_camera"] = pose_json(handeye.mount_from_camera);
  json["holder_from_board"] = pose_json(handeye.holder_from_board);
  json["covariance"] = matrix_json(handeye.covariance);
  json["board_scale"] = handeye.board_scale;
  json["sigma_board_scale"] = handeye.sigma_board_scale;
  json["robot_sigma_m"] = handeye.robot_sigma_m;
  json["robot_sigma_rad"] = handeye.robot_sigma_rad;
  json["robot_sigma_m_share"] = handeye.robot_sigma_m_share;
  json["robot_sigma_rad_share"] = handeye.robot_sigma_rad_share;
  json["degrees_of_freedom"] = handeye.degrees_of_freedom;
  json["rotation_rad"] = handeye.rotation_rad;
  json["axis_spread_rad"] = handeye.axis_spread_rad;
  json["board_spread_m"] = handeye.board_spread_m;
  json["rms_px"] = handeye.rms_px;
  json["sigma_px"] = handeye.sigma_px;
  json["num_corners"] = handeye.num_corners;
}

Json names_json(std::span<const std::size_t> indices, std::span<const HandeyeView> views) {
  Json names = Json::array();
  for (const std::size_t i : indices) names.push_back(views[i].image);
  return names;
}

}  // namespace

std::string handeye_verdict(const HandeyeEstimate& handeye) {
  if (!is_answer(handeye.status)) return no_answer_text(handeye.status, handeye.findings);
  std::string text =
      fmt::format("{}camera on the {}, {}", ok_text(handeye.findings),
                  handeye.mount == CameraMount::hand ? "hand" : "base (beside the robot)",
                  counted(handeye.views.size(), "pose"));
  if (handeye.num_corners == 0) return text;
  return text + fmt::format(", {}, rms {} px",
                            counted(static_cast<std::size_t>(handeye.num_corners), "corner"),
                            two_digits(handeye.rms_px));
}

std::string camera_title(const HandeyeEstimate& handeye, const HandeyeInput& input) {
  const std::string camera = !input.reference ? "camera"
                             : input.reference->empty()
                                 ? "the rig's frame"
                                 : *input.reference + " (the rig's reference)";
  return camera + " in the " + mount_name(handeye.mount);
}

std::string board_title(const HandeyeEstimate& handeye) {
  return "board in the " + holder_name(handeye.mount);
}

std::string robot_text(const HandeyeEstimate& handeye) {
  return fmt::format("{} mm and {} deg per axis (+- {:.0f} % and {:.0f} %), board's spread {} mm",
                     two_digits(1e3 * handeye.robot_sigma_m),
                     two_digits(degrees(handeye.robot_sigma_rad)),
                     100 * handeye.robot_sigma_m_share, 100 * handeye.robot_sigma_rad_share,
                     two_digits(1e3 * handeye.board_spread_m));
}

std::string axes_text(const HandeyeEstimate& handeye) {
  return fmt::format("turned by {} deg (RMS), spread {} deg (45 is best)",
                     two_digits(degrees(handeye.rotation_rad)),
                     two_digits(degrees(handeye.axis_spread_rad)));
}

std::string clocks_text(const HandeyeEstimate& handeye) {
  if (!handeye.time_offset_s) return "";
  return with_sigma(1e3 * *handeye.time_offset_s, 1e3 * handeye.sigma_time_offset_s) +
         " ms from the pictures' times to the robot's";
}

bool has_places(const HandeyeEstimate& handeye) {
  return is_answer(handeye.status) || handeye.status == Status::rotation_axes_parallel ||
         handeye.status == Status::no_rotation;
}

std::string handeye_summary(const HandeyeEstimate& handeye, const HandeyeInput& input) {
  std::string text = verdict_lines(handeye_verdict(handeye), handeye.status, handeye.findings) +
                     findings_text(without_reason(handeye.findings), "");
  if (has_places(handeye)) {
    text += place_lines(camera_title(handeye, input), handeye.mount_from_camera,
                        handeye.camera_covariance);
    text += place_lines(board_title(handeye), handeye.holder_from_board, handeye.board_covariance);
    text += "\nrobot    " + robot_text(handeye) + "\naxes     " + axes_text(handeye) + "\n";
    if (handeye.time_offset_s) text += "clocks   " + clocks_text(handeye) + "\n";
    text += worst_lines(handeye, input.views);
  }
  return handeye.next ? text + "\n" + wrapped("next: ", handeye.next->sentence, 6) : text;
}

std::string handeye_json(const HandeyeEstimate& handeye, const HandeyeInput& input) {
  const std::vector<HandeyeView>& views = input.views;
  Json json = {{"status", status_name(handeye.status)},
               {"mount", mount_name(handeye.mount)},
               {"findings", findings_json(handeye.findings)}};
  if (input.reference && !input.reference->empty()) json["reference"] = *input.reference;
  if (!handeye.views.empty()) add_numbers(handeye, json);
  json["views"] = Json::array();
  for (const HandeyeViewFit& fit : handeye.views) json["views"].push_back(view_json(fit, views));
  json["rejected"] = names_json(handeye.rejected, views);
  json["unusable"] = names_json(handeye.unusable, views);
  if (handeye.reading)
    json["reading"] = {{"change", handeye.reading->change},
                       {"times_better", handeye.reading->times_better}};
  if (handeye.time_offset_s)
    json["time_offset"] = {{"offset_s", *handeye.time_offset_s},
                           {"sigma_s", handeye.sigma_time_offset_s}};
  if (handeye.next)
    json["next"] = {{"base_from_hand", pose_json(handeye.next->base_from_hand)},
                    {"sigma_m", handeye.next->sigma_m},
                    {"sigma_now_m", handeye.next->sigma_now_m},
                    {"sigma_rad", handeye.next->sigma_rad},
                    {"sigma_now_rad", handeye.next->sigma_now_rad},
                    {"sentence", handeye.next->sentence}};
  json["seconds"] = handeye.seconds;
  return json_text(json);
}

}  // namespace tagcal::tools
