#include "page_data/pages.hpp"

#include <fmt/format.h>

#include "job/terminal.hpp"
#include "page_data/page_parts.hpp"
#include "report/rig_report.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/handeye_file.hpp"

namespace tagcal::tools {
namespace {

using internal::degrees;

// Where the robot says that its hand was. None: outside of its path.
std::optional<Pose> given_hand(const HandeyeView& view, const HandeyeOptions& options,
                               const HandeyeEstimate& answer) {
  if (!options.path) return view.base_from_hand;
  const double offset_s = options.find_time_offset ? answer.time_offset_s.value_or(0) : 0;
  return hand_at(*options.path, *view.time_s + offset_s);
}

// The robot's deviation in one view: numbers for charts, and the texts of the terminal.
void add_fit(const HandeyeViewFit& fit, PageJson& pose) {
  pose["state"] = "used";
  pose["base_from_hand"] = matrix_json(fit.base_from_hand);
  pose["error_m"] = significant(fit.error_m);
  pose["error_rad"] = significant(fit.error_rad);
  pose["score"] = significant(fit.score);
  pose["rms_px"] = significant(fit.rms_px);
  pose["texts"] = {std::isfinite(fit.rms_px) ? two_digits(fit.rms_px) : "",
                   two_digits(1e3 * fit.error_m), two_digits(degrees(fit.error_rad)),
                   fmt::format("{:.1f}", fit.score)};
}

// All views in their order. Those that take part in an answer have the robot's deviation.
PageJson handeye_poses_json(const HandeyeInput& input, const HandeyeOptions& options,
                            const HandeyeEstimate& answer) {
  PageJson list = PageJson::array();
  for (const HandeyeView& view : input.views) {
    const auto hand = given_hand(view, options, answer);
    list.push_back({{"image", view.image},
                    {"state", "given"},
                    {"base_from_hand", hand ? matrix_json(*hand) : PageJson()}});
  }
  for (const std::size_t i : answer.rejected) list[i]["state"] = "rejected";
  for (const std::size_t i : answer.unusable) list[i]["state"] = "unusable";
  if (has_places(answer))
    for (const HandeyeViewFit& fit : answer.views) add_fit(fit, list[fit.view]);
  return list;
}

PageJson inputs_json(const HandeyeInput& input, const std::vector<InputRow>& inputs,
                     const HandeyeEstimate& answer) {
  const char* const kind = input.camera ? "picture" : input.reference ? "instant" : "pose";
  PageJson rows = PageJson::array();
  rows.push_back({std::string(kind) + "s", input.name});
  for (const InputRow& row : inputs) rows.push_back({row.name, row.text});
  rows.push_back({"mount", answer.mount == CameraMount::hand
                               ? "hand: the camera is on the hand, the board is at rest"
                               : "base: the camera is at rest, the board is in the hand"});
  std::string counts = counted(input.pictures.size(), kind);
  if (input.camera) counts += fmt::format(", {} with the board", input.views.size());
  if (!answer.views.empty()) counts += fmt::format(", {} used", answer.views.size());
  for (const auto& [number, what] :
       {std::pair(answer.rejected.size(), "rejected (the robot's pose contradicts the others)"),
        std::pair(answer.unusable.size(), "without a pose of the board or of the robot")})
    if (number > 0) counts += fmt::format(", {} {}", number, what);
  rows.push_back({"number", counts});
  if (answer.num_corners > 0)
    rows.push_back({"corners", fmt::format("{}, sd {} px per coordinate", answer.num_corners,
                                           two_digits(answer.sigma_px))});
  return rows;
}

// What the terminal and --out, --ros write.
PageJson handeye_formats_json(const HandeyeEstimate& answer) {
  PageJson list = PageJson::array();
  if (!is_answer(answer.status)) return list;
  const std::string ros = handeye_ros_text(answer);
  const std::size_t end = ros.find('\n');
  list.push_back({{"name", "ROS 2 (command)"}, {"text", ros.substr(2, end - 2) + "\n"}});
  list.push_back({{"name", "ROS (TransformStamped, as --ros)"}, {"text", ros}});
  list.push_back({{"name", "tagcal (handeye.yaml, as --out)"}, {"text", handeye_yaml(answer)}});
  return list;
}

// The places and the robot's noise as the terminal has them, and the places for a picture.
void add_places(const HandeyeInput& input, const HandeyeEstimate& answer, PageJson& page) {
  page["places"] = {{{"title", camera_title(answer, input)},
                     {"texts", place_texts(answer.mount_from_camera, answer.camera_covariance)}},
                    {{"title", board_title(answer)},
                     {"texts", place_texts(answer.holder_from_board, answer.board_covariance)}}};
  page["robot"] = {{"sigma_m", significant(answer.robot_sigma_m)},
                   {"sigma_rad", significant(answer.robot_sigma_rad)},
                   {"mm", two_digits(1e3 * answer.robot_sigma_m)},
                   {"deg", two_digits(degrees(answer.robot_sigma_rad))},
                   {"text", robot_text(answer)},
                   {"axes", axes_text(answer)},
                   {"clocks", clocks_text(answer)}};
  if (!is_answer(answer.status)) return;  // translations are arbitrary
  page["mount_from_camera"] = matrix_json(answer.mount_from_camera);
  page["holder_from_board"] = matrix_json(answer.holder_from_board);
}

}  // namespace

PageJson handeye_page(const HandeyeInput& input, const std::vector<InputRow>& inputs,
                      const HandeyeOptions& options, const HandeyeEstimate& answer) {
  PageJson page = {
      {"format", 1},
      {"kind", "handeye"},
      {"title", last_part(input.name)},
      {"verdict", verdict_json(answer.status, answer.findings, handeye_verdict(answer))},
      {"status", status_name(answer.status)},
      {"made_by", made_by_json()},
      {"findings", page_findings_json(answer.findings)},
      {"notes", PageJson::array()},
      {"mount", mount_name(answer.mount)},
      {"holder", holder_name(answer.mount)},
      {"num_corners", answer.num_corners},
      {"rms_px", has_places(answer) ? significant(answer.rms_px) : PageJson()},
      {"next", nullptr},
      {"places", PageJson::array()},
      {"seconds", significant(answer.seconds, 3)}};
  if (has_places(answer)) add_places(input, answer, page);
  if (answer.next) {
    page["next"] = answer.next->sentence;
    page["next_hand"] = matrix_json(answer.next->base_from_hand);
    if (is_answer(answer.status))
      page["known_to"] = fmt::format("{} mm", two_digits(1e3 * answer.next->sigma_now_m));
  }
  if (input.image_size.width > 0)
    page["image_size"] = {input.image_size.width, input.image_size.height};
  page["boards"] = boards_json(input.boards);
  page["poses"] = handeye_poses_json(input, options, answer);
  page["inputs"] = inputs_json(input, inputs, answer);
  page["formats"] = handeye_formats_json(answer);
  return page;
}

}  // namespace tagcal::tools
