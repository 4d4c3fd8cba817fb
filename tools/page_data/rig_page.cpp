#include "page_data/pages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <filesystem>

#include "job/terminal.hpp"
#include "page_data/page_parts.hpp"
#include "report/findings.hpp"
#include "report/json_parts.hpp"
#include "report/rig_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kMostNames = 4;  // of cameras in a title

std::string title_of(const RigDataset& data) {
  std::vector<std::string> names;
  for (const RigCamera& camera : data.cameras) names.push_back(camera.name);
  if (names.size() <= kMostNames) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{} cameras, {} to {}", names.size(), names.front(), names.back());
}

// The half axes of the ellipsoid of one standard deviation of a camera's centre, in the rig's
// frame: the centre -R't moves by -R'([t]x omega + tau).
PageJson centre_axes_json(const Pose& camera_from_rig, const Matrix6& covariance) {
  const Eigen::Matrix3d turn = camera_from_rig.rotation_matrix().transpose();
  Eigen::Matrix<double, 3, 6> by;
  by << -turn * cross_matrix(camera_from_rig.translation()), -turn;
  const Eigen::Matrix3d of_centre = by * covariance * by.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(of_centre);
  PageJson axes = PageJson::array();
  for (int i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(std::max(0.0, solver.eigenvalues()[i]));
    PageJson axis = PageJson::array();
    for (int k = 0; k < 3; ++k) axis.push_back(significant(sigma * solver.eigenvectors()(k, i), 4));
    axes.push_back(std::move(axis));
  }
  return axes;
}

// The keys of a lens, as a page of one camera has them. `content` has the camera's data, or none.
void add_lens(const FileCamera& camera, PageContent& content, PageJson& json) {
  const std::vector<CalibratedView> views = std::move(content.calibration.views);
  const std::vector<Outlier> outliers = std::move(content.calibration.outliers);
  content.calibration = calibration_of(camera.calibration);
  content.calibration.views = views;
  content.calibration.outliers = outliers;
  const Calibration& c = content.calibration;
  json["model"] = c.model;
  json["image_size"] = {c.camera->image_size.width, c.camera->image_size.height};
  json["parameters"] = parameters_json(c);
  json["seen"] = seen_json(c.seen);
  json["projection"] = projection_maps_json(content);
  if (content.dataset.views.empty()) return;
  json["corners"] = corners_json(page_corners(content));
  for (const char* const column : {"du", "dv", "sd_px", "tag", "corner"})  // of its own calibration
    json["corners"].erase(column);
}

void add_place(const KnownRig& rig, std::size_t c, PageJson& json) {
  const Pose& place = rig.cameras[c].camera_from_rig;
  json["rig_from_camera"] = matrix_json(place.inverse());
  Matrix6 covariance = Matrix6::Zero();
  const auto at = 6 * static_cast<Eigen::Index>(c);
  if (rig.covariance.size() > 0) covariance = rig.covariance.block<6, 6>(at, at);
  if (!covariance.isZero()) json["centre_axes_m"] = centre_axes_json(place, covariance);
  if (rig.reference() != c) json["place"] = place_texts(place, covariance);
}

PageJson rig_pair_json(const RigPair& pair, bool of_instants, bool of_several) {
  PageJson depths = PageJson::array();
  for (const DepthUncertainty& d : pair.depths)
    depths.push_back({{"distance_m", d.distance_m},
                      {"sigma_m", significant(d.sigma_m, 4)},
                      {"of_lenses_m", significant(d.of_lenses_m, 4)},
                      {"text", depth_text(d)}});
  PageJson json = {{"a", pair.a},
                   {"b", pair.b},
                   {"baseline", baseline_text(pair)},
                   {"depths", std::move(depths)}};
  if (!of_instants) return json;
  json["num_instants"] = pair.num_instants;
  json["epipolar_px"] = two_digits(pair.epipolar_px);
  if (!of_several) return json;
  json["disagreement_sd"] = significant(pair.disagreement, 4);
  json["disagreement"] = disagreement_text(pair);
  return json;
}

PageJson clocks_json(const RigCalibration& rig, const RigOptions& options) {
  PageJson list = PageJson::array();
  for (const ClockOffset& clock : rig.clocks)
    list.push_back({{"camera", clock.camera},
                    {"text", offset_text(clock)},
                    {"corrected", options.find_clocks}});
  return list;
}

// All instants in the order of time, with the cameras that have a picture of them.
PageJson instants_json(const RigDataset& data, const RigCalibration& rig) {
  PageJson list = PageJson::array();
  for (const Instant& instant : data.instants) {
    PageJson cameras = PageJson::array();
    PageJson time_s;
    for (std::size_t c = 0; c < instant.view.size(); ++c) {
      if (!instant.view[c]) continue;
      cameras.push_back(c);
      const std::vector<double>& times = data.cameras[c].times_s;
      if (time_s.is_null() && !times.empty()) time_s = decimals(times[*instant.view[c]], 6);
    }
    list.push_back({{"name", name_of(instant, data)},
                    {"cameras", std::move(cameras)},
                    {"time_s", std::move(time_s)},
                    {"state", "unused"},
                    {"num_used", 0},  // pictures
                    {"rig_from_world", nullptr}});
  }
  for (const RigInstant& used : rig.instants) {
    list[used.index]["state"] = "used";
    list[used.index]["num_used"] = used.num_views;
    list[used.index]["rig_from_world"] = matrix_json(used.rig_from_world);
  }
  for (const std::size_t t : rig.rejected_instants) list[t]["state"] = "rejected";
  return list;
}

// The boards as the rig has them.
std::vector<PlacedBoard> placed_boards(const RigDataset& data, const RigCalibration& rig,
                                       const RigOptions& options) {
  std::vector<PlacedBoard> boards = data.cameras.front().data.boards;
  for (std::size_t b = 0; options.find_boards && b < boards.size() && b < rig.boards.size(); ++b)
    boards[b].world_from_board = rig.boards[b].world_from_board;
  return boards;
}

PageJson start_of_page(const std::string& title, Status status,
                       const std::vector<Finding>& findings, const std::string& verdict) {
  return {{"format", 1},
          {"kind", "rig"},
          {"title", title},
          {"verdict", verdict_json(status, findings, verdict)},
          {"status", status_name(status)},
          {"made_by", made_by_json()},
          {"findings", page_findings_json(findings)}};
}

void add_summary_of_rig(const RigDataset& data, const RigCalibration& rig, PageJson& page) {
  page["rms_px"] = is_answer(rig.status) ? significant(rig.rms_px) : PageJson();
  page["num_corners"] = rig.num_corners;
  page["num_instants"] = rig.instants.size();
  page["num_paired"] = data.instants.size();
  page["next"] = rig.next ? PageJson(rig.next->sentence) : PageJson();
  page["seconds"] = significant(rig.seconds, 3);
}

PageJson camera_of_answer_json(const RigCameraEstimate& camera, bool has_rig) {
  PageJson json = {{"name", camera.name}};
  if (!has_rig) return json;
  json["model"] = camera.model;
  json["num_views"] = camera.num_views;
  json["num_corners"] = camera.num_corners;
  json["rms_px"] = two_digits(camera.rms_px);
  json["excess"] = excess_text(camera);
  if (camera.own.readout) json["readout"] = readout_json(*camera.own.readout);
  json["findings"] = page_findings_json(camera.own.findings);
  return json;
}

}  // namespace

PageJson rig_page(const RigDataset& data, const RigCalibration& answer, const RigOptions& options,
                  const std::vector<std::map<std::string, std::filesystem::path>>& pictures) {
  PageJson page =
      start_of_page(title_of(data), answer.status, answer.findings, rig_verdict(answer));
  add_summary_of_rig(data, answer, page);
  const bool answered = is_answer(answer.status);
  const CameraFile file = answered ? camera_file(answer) : CameraFile();
  const KnownRig rig = answered ? known_rig(answer) : KnownRig();
  page["reference"] = options.reference;
  page["cameras"] = PageJson::array();
  for (std::size_t c = 0; c < answer.cameras.size(); ++c) {
    PageJson json = camera_of_answer_json(answer.cameras[c], !answer.groups.empty());
    if (answered) {
      PageContent content;
      content.calibration = answer.cameras[c].own;
      content.dataset = data.cameras[c].data;
      add_lens(file.cameras[c], content, json);
      add_place(rig, c, json);
    }
    page["cameras"].push_back(std::move(json));
  }
  page["pairs"] = PageJson::array();
  for (const RigPair& pair : answer.pairs)
    page["pairs"].push_back(rig_pair_json(pair, true, answer.cameras.size() > 2));
  page["rectified"] = answered ? rectified_json(data, answer, pictures) : PageJson();
  page["boards"] = boards_json(placed_boards(data, answer, options));
  page["instants"] = instants_json(data, answer);
  page["clocks"] = clocks_json(answer, options);
  std::vector<std::string> notes;
  page["formats"] = answered ? formats_json(file, notes) : PageJson::array();
  page["notes"] = notes;
  return page;
}

PageJson rig_page(const CameraFile& file, const std::string& name) {
  const KnownRig rig = known_rig(file, name);
  PageJson page = start_of_page(last_part(name), Status::ok, file.findings,
                                ok_text(file.findings) + counted(rig.cameras.size(), "camera"));
  std::vector<std::string> notes = {
      "A file of a rig has no instants: boards, the timeline, residuals, the disagreement of the "
      "pairs and the next view are on the page of a new calibration (tagcal rig --report)."};
  if (rig.covariance.size() == 0)
    notes.emplace_back("The file has no covariance: how well places and depths are known is not.");
  page["reference"] = rig.reference() ? PageJson(*rig.reference()) : PageJson();
  page["cameras"] = PageJson::array();
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    PageContent content;
    PageJson json = {{"name", file.cameras[c].name}};
    add_lens(file.cameras[c], content, json);
    add_place(rig, c, json);
    page["cameras"].push_back(std::move(json));
  }
  page["pairs"] = PageJson::array();
  for (const RigPair& pair : pairs_of(rig))
    page["pairs"].push_back(rig_pair_json(pair, false, false));
  page["formats"] = formats_json(file, notes);
  page["notes"] = notes;
  return page;
}

std::optional<CameraFile> rig_in_file(const std::string& name) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(name, unknown)) return std::nullopt;
  try {
    CameraFile file = read_camera_file(name);
    const bool has_places = std::ranges::all_of(
        file.cameras, [](const FileCamera& camera) { return camera.camera_from_rig.has_value(); });
    if (file.cameras.size() > 1 && has_places) return file;
  } catch (const Error&) {  // the page of a camera says why
  }
  return std::nullopt;
}

}  // namespace tagcal::tools
