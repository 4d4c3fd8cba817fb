#include "report/rig_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "report/calibration_report.hpp"
#include "report/findings.hpp"
#include "report/json_parts.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

using internal::degrees;

double sigma_of(const Matrix6& covariance, int i) {
  return std::sqrt(std::max(0.0, covariance(i, i)));
}

std::size_t name_width(const RigCalibration& rig) {
  std::size_t width = 6;
  for (const RigCameraEstimate& camera : rig.cameras) width = std::max(width, camera.name.size());
  return width;
}

std::string camera_rows(const RigCalibration& rig) {
  const std::size_t width = name_width(rig);
  std::string text = fmt::format("\n{:<{}}  {:<9} {:>6} {:>8} {:>7} {:>7}\n", "camera", width,
                                 "model", "views", "corners", "rms px", "excess");
  for (const RigCameraEstimate& camera : rig.cameras)
    text += fmt::format("{:<{}}  {:<9} {:>6} {:>8} {:>7} {:>7}\n", camera.name, width, camera.model,
                        camera.num_views, camera.num_corners, two_digits(camera.rms_px),
                        excess_text(camera));
  for (const RigCameraEstimate& camera : rig.cameras)
    if (camera.own.readout)
      text += wrapped(camera.name + ": readout ", readout_text(*camera.own.readout), 2);
  return text;
}

std::string length_text(double metres) {
  return metres < 0.1 ? two_digits(1e3 * metres) + " mm" : two_digits(metres) + " m";
}

std::string pair_lines(const RigCalibration& rig, const RigPair& pair) {
  std::string text =
      fmt::format("\n{} - {}: baseline {}, {}, epipolar error {} px", rig.cameras[pair.a].name,
                  rig.cameras[pair.b].name, baseline_text(pair),
                  counted(static_cast<std::size_t>(pair.num_instants), "instant"),
                  two_digits(pair.epipolar_px));
  if (rig.cameras.size() > 2)
    text += fmt::format(", disagrees with the rig by {}", disagreement_text(pair));
  const std::string depths = internal::joined(pair.depths, ", ", depth_text);
  text += "\n";
  if (!depths.empty()) text += wrapped("  depth ", depths, 8);
  return text;
}

// The place of a board, in the frame of the board that the reference sees most.
std::string board_lines(std::size_t index, const RigBoard& board) {
  const Vector3d t = 1e3 * board.world_from_board.translation();
  std::string text = fmt::format("{}board {} at", index == 0 ? "\n" : "", index + 1);
  if (!board.is_connected) return text + " an unknown place: no camera sees it with another\n";
  for (int i = 0; i < 3; ++i)
    text += fmt::format("  {:>16}", with_sigma(t[i], 1e3 * sigma_of(board.covariance, 3 + i)));
  return text + " mm\n";
}

std::string next_line(const RigCalibration& rig) {
  return rig.next ? "\n" + wrapped("next: ", rig.next->sentence, 6) : "";
}

Json camera_json(const RigCameraEstimate& camera) {
  Json json = {{"name", camera.name},
               {"model", camera.model},
               {"own_status", status_name(camera.own.status)},
               {"connected", camera.is_connected},
               {"num_views", camera.num_views},
               {"num_corners", camera.num_corners},
               {"rms_px", camera.rms_px},
               {"excess", camera.excess},
               {"readout", readout_json(camera.own.readout)}};
  if (!camera.is_connected) return json;
  json["camera_from_rig"] = pose_json(camera.camera_from_rig);
  json["camera_from_rig_covariance"] = matrix_json(camera.covariance);
  Json lens;
  const auto names = parameter_names(camera.camera.camera.lens);
  const auto values = parameters(camera.camera.camera.lens);
  const std::vector<double> sigmas = lens_sigmas(camera.camera);
  for (std::size_t i = 0; i < names.size(); ++i)
    lens[std::string(names[i])] = {{"value", values[i]}, {"sigma", sigmas[i]}};
  json["lens"] = lens;
  return json;
}

Json rig_pair_json(const RigCalibration& rig, const RigPair& pair) {
  Json depths = Json::array();
  for (const DepthUncertainty& d : pair.depths)
    depths.push_back(
        {{"distance_m", d.distance_m}, {"sigma_m", d.sigma_m}, {"of_lenses_m", d.of_lenses_m}});
  return {{"a", rig.cameras[pair.a].name},
          {"b", rig.cameras[pair.b].name},
          {"num_instants", pair.num_instants},
          {"num_corners", pair.num_corners},
          {"b_from_a", pose_json(pair.b_from_a)},
          {"covariance", matrix_json(pair.covariance)},
          {"baseline_m", pair.baseline_m},
          {"sigma_baseline_m", pair.sigma_baseline_m},
          {"disagreement_sd", rig.cameras.size() > 2 ? Json(pair.disagreement) : Json()},
          {"epipolar_px", pair.epipolar_px},
          {"depths", depths}};
}

}  // namespace

std::string rig_verdict(const RigCalibration& rig) {
  if (!is_answer(rig.status)) return no_answer_text(rig.status, rig.findings);
  return fmt::format("{}{}, {}, {}, rms {} px", ok_text(rig.findings),
                     counted(rig.cameras.size(), "camera"), counted(rig.instants.size(), "instant"),
                     counted(static_cast<std::size_t>(rig.num_corners), "corner"),
                     two_digits(rig.rms_px));
}

std::vector<std::string> place_texts(const Pose& camera_from_rig, const Matrix6& covariance) {
  const Vector3d t = 1e3 * camera_from_rig.translation();
  const Vector3d r = degrees(1) * log_rotation(camera_from_rig.rotation());
  std::vector<std::string> texts;
  for (int i = 0; i < 3; ++i) texts.push_back(with_sigma(t[i], 1e3 * sigma_of(covariance, 3 + i)));
  for (int i = 0; i < 3; ++i)
    texts.push_back(with_sigma(r[i], degrees(1) * sigma_of(covariance, i)));
  return texts;
}

std::string place_lines(const std::string& title, const Pose& camera_from_rig,
                        const Matrix6& covariance) {
  std::string lines = "\n" + title + "\n";
  const std::vector<std::string> texts = place_texts(camera_from_rig, covariance);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (i == 0) lines += "  translation mm ";
    if (i == 3) lines += "\n  rotation deg   ";
    lines += fmt::format("  {:>18}", texts[i]);
  }
  return lines + "\n";
}

std::string baseline_text(const RigPair& pair) {
  return with_sigma(1e3 * pair.baseline_m, 1e3 * pair.sigma_baseline_m) + " mm";
}

std::string depth_text(const DepthUncertainty& depth) {
  return fmt::format("at {:g} m +- {} ({} of it by the lenses)", depth.distance_m,
                     length_text(depth.sigma_m), length_text(depth.of_lenses_m));
}

std::string disagreement_text(const RigPair& pair) {
  return fmt::format("{:.1f} sd", pair.disagreement);
}

std::string excess_text(const RigCameraEstimate& camera) {
  return fmt::format("{:.2f}", camera.excess);
}

std::string name_of(const Instant& instant, const RigDataset& data) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < data.cameras.size(); ++c)
    if (const auto& view = instant.view[c]) {
      const std::string& name = data.cameras[c].data.views[*view].image;
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string rig_summary(const RigCalibration& rig, std::size_t reference) {
  std::string text = verdict_lines(rig_verdict(rig), rig.status, rig.findings) +
                     findings_text(without_reason(rig.findings), "");
  const bool has_rig = !rig.groups.empty();
  if (has_rig) text += camera_rows(rig);
  if (!is_answer(rig.status)) return text + next_line(rig);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (c != reference)
      text += place_lines(rig.cameras[c].name + " from " + rig.cameras[reference].name,
                          rig.cameras[c].camera_from_rig, rig.cameras[c].covariance);
  for (const RigPair& pair : rig.pairs) text += pair_lines(rig, pair);
  for (std::size_t b = 0; b < rig.boards.size() && rig.boards.size() > 1; ++b)
    text += board_lines(b, rig.boards[b]);
  return text + next_line(rig);
}

std::string rig_json(const RigDataset& data, const RigCalibration& rig, std::size_t reference) {
  Json json = {{"status", status_name(rig.status)},
               {"reference", rig.cameras[reference].name},
               {"num_instants", rig.instants.size()},
               {"num_paired", data.instants.size()},
               {"rejected_instants", rig.rejected_instants},
               {"num_corners", rig.num_corners},
               {"rms_px", rig.rms_px},
               {"findings", findings_json(rig.findings)}};
  json["cameras"] = Json::array();
  for (const RigCameraEstimate& camera : rig.cameras)
    json["cameras"].push_back(camera_json(camera));
  json["pairs"] = Json::array();
  for (const RigPair& pair : rig.pairs) json["pairs"].push_back(rig_pair_json(rig, pair));
  json["boards"] = Json::array();
  for (const RigBoard& board : rig.boards)
    json["boards"].push_back({{"world_from_board", pose_json(board.world_from_board)},
                              {"covariance", matrix_json(board.covariance)},
                              {"connected", board.is_connected}});
  if (rig.next)
    json["next"] = {{"a", rig.cameras[rig.next->a].name},
                    {"b", rig.cameras[rig.next->b].name},
                    {"distance_m", rig.next->distance_m},
                    {"sigma_px", rig.next->sigma_px},
                    {"sentence", rig.next->sentence}};
  json["covariance"] = matrix_json(rig.covariance);
  json["seconds"] = rig.seconds;
  return json_text(json);
}

}  // namespace tagcal::tools
