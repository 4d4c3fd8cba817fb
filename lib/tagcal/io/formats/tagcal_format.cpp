#include "tagcal/io/formats/tagcal_format.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_camera.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::internal {
namespace {

Eigen::MatrixXd row_of(const std::vector<double>& values) {
  return Eigen::RowVectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::vector<std::string_view> free_names(const Model& model) {
  std::vector<std::string_view> names;
  for (const FreeParameter& free : model.free()) names.push_back(free.name);
  return names;
}

std::string fixed_yaml(const std::map<std::string, double>& fixed) {
  if (fixed.empty()) return "";
  std::string values;
  for (const auto& [name, value] : fixed)
    values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", name, value);
  return fmt::format("fixed: {{ {} }}\n", values);
}

}  // namespace

std::string camera_yaml(const Camera& camera, std::string_view model) {
  const std::span<const double> p = parameters(camera.lens);
  const std::string size = fmt::format("image_width: {}\nimage_height: {}\n",
                                       camera.image_size.width, camera.image_size.height);
  if (!kind_of(camera.lens).is_central) return size;
  Eigen::Matrix3d matrix;
  matrix << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1;
  return size + matrix_yaml("camera_matrix", matrix) +
         matrix_yaml("distortion_coefficients", row_of(distortion_of(camera.lens, model)));
}

std::string uncertainty_yaml(const CalibrationFile& calibration) {
  std::string text = fixed_yaml(calibration.fixed);
  const Lens& lens = calibration.camera.lens;
  if (kind_of(lens).is_central && !calibration.sigmas.empty()) {
    text += texts_yaml("parameter_names", parameter_names(lens)) +
            matrix_yaml("sigmas", row_of(calibration.sigmas));
  }
  if (calibration.covariance.size() > 0) {
    const HeldModels models(calibration.fixed, Model::named(calibration.model).kind());
    text += texts_yaml("covariance_names", free_names(models.named(calibration.model))) +
            matrix_yaml("covariance", calibration.covariance);
  }
  if (calibration.claim_covariance.size() > 0)
    text += fmt::format("claim_model: {}\n", text_yaml(calibration.claim_model)) +
            texts_yaml("claim_names", free_names(Model::named(calibration.claim_model))) +
            matrix_yaml("claim_covariance", calibration.claim_covariance);
  return text;
}

std::string seen_yaml(const SeenRegion& seen) {
  const std::vector<Eigen::Vector2d>& hull = seen.hull();
  if (hull.empty()) return "";
  Eigen::MatrixXd corners(static_cast<Eigen::Index>(hull.size()), 2);
  for (std::size_t i = 0; i < hull.size(); ++i)
    corners.row(static_cast<Eigen::Index>(i)) = hull[i].transpose();
  return matrix_yaml("seen_region", corners);
}

std::string findings_yaml(const std::vector<Finding>& findings) {
  std::vector<std::string> codes, severities;
  for (const Finding& finding : findings) {
    codes.push_back(finding.code);
    severities.emplace_back(severity_name(finding.severity));
  }
  // Those of older files have no codes, and an empty text is no code.
  while (!codes.empty() && codes.back().empty()) codes.pop_back();
  return texts_yaml("warnings", sentences(findings)) + texts_yaml("warning_codes", codes) +
         texts_yaml("warning_severities", severities);
}

std::string image_line(const std::string& image, std::size_t view, std::set<std::string>& names) {
  const std::string name = image.empty() ? view_name(view) : image;
  if (!names.insert(name).second)
    throw Error(fmt::format("views[{}].image: two views have the name {}", view, shown(name)));
  return fmt::format("   - image: {}\n", text_yaml(name));
}

std::string pose_lines(const Pose& pose, std::string_view prefix) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format(
      "     {0}rotation: [ {1}, {2}, {3}, {4} ]\n     {0}translation_m: [ {5}, {6}, {7} ]\n",
      prefix, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
}

namespace {

// The keys of a camera. One of another program has no name of a model: it gets that of the smallest
// with all its coefficients and a free focal length and principal point.
std::string calibration_keys(CalibrationFile calibration) {
  const Lens& lens = calibration.camera.lens;
  if (!kind_of(lens).is_central)
    throw Error("a parallel camera has no focal length: a calibration file cannot hold it");
  if (calibration.model.empty()) calibration.model = full_model(lens).name();
  std::string text = camera_yaml(calibration.camera, calibration.model) +
                     fmt::format("model: {}\n", text_yaml(calibration.model));
  if (calibration.camera_error_px)
    text += fmt::format("camera_error_px: {}\n", number_yaml(*calibration.camera_error_px));
  text += uncertainty_yaml(calibration) + seen_yaml(calibration.seen);
  return calibration.findings.empty() ? text : text + findings_yaml(calibration.findings);
}

// Lines as one item of a list.
std::string as_item(const std::string& lines) {
  std::string text;
  for (std::size_t at = 0; at < lines.size();) {
    const std::size_t end = lines.find('\n', at) + 1;
    text += (at == 0 ? "   - " : "     ") + lines.substr(at, end - at);
    at = end;
  }
  return text;
}

// The rig without its covariance; no value if a camera has no place.
std::optional<KnownRig> known_rig_of(const CameraFile& file) {
  KnownRig rig;
  for (const FileCamera& camera : file.cameras) {
    if (!camera.camera_from_rig) return std::nullopt;
    rig.cameras.push_back({"", uncertain_camera(camera.calibration), *camera.camera_from_rig, {}});
  }
  return rig;
}

// The joint covariance as `tagcal rig` writes it: without the place of the reference. A note if the
// cameras are not those that it is of.
std::string rig_covariance_yaml(const CameraFile& file, std::vector<std::string>& notes) {
  const MatrixX& all = file.rig_covariance;
  if (all.size() == 0) return "";
  const std::optional<KnownRig> rig = known_rig_of(file);
  const auto reference = rig ? rig->reference() : std::nullopt;
  if (!reference || rig->first_of_lens(rig->cameras.size()) != all.rows()) {
    notes.emplace_back("dropped: the covariance of the rig, which is of other places or lenses");
    return "";
  }
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < all.rows(); ++i)
    if (i / 6 != static_cast<Eigen::Index>(*reference)) kept.push_back(i);
  return matrix_yaml("joint_covariance", all(kept, kept));
}

std::string rig_keys(const CameraFile& file, std::vector<std::string>& notes) {
  return (file.rig_is_imu ? "rig_frame: imu\n" : "") + cameras_yaml(file.cameras) +
         rig_covariance_yaml(file, notes) +
         (file.findings.empty() ? "" : findings_yaml(file.findings));
}

}  // namespace

std::string cameras_yaml(const std::vector<FileCamera>& cameras) {
  std::string text = "cameras:\n";
  for (const FileCamera& camera : cameras) {
    std::string lines = fmt::format("name: {}\n", text_yaml(camera.name));
    if (camera.camera_from_rig)
      lines += fmt::format("camera_from_rig: {}\n", pose_yaml(*camera.camera_from_rig));
    if (camera.overlaps)
      lines += fmt::format("overlaps: [{}]\n", fmt::join(*camera.overlaps, ", "));
    if (camera.imu_time_shift_s)
      lines += fmt::format("imu_time_shift_s: {}\n", number_yaml(*camera.imu_time_shift_s));
    text += as_item(lines + calibration_keys(camera.calibration));
  }
  return text;
}

bool has_rig_keys(const YamlValue& top) {
  const auto cameras = top.find("cameras");
  if (!cameras || !cameras->is_list()) return false;
  const auto items = cameras->items(0, limits::kMaxRigCameras);
  return !items.empty() && items.front().is_map() && items.front().find("name") &&
         items.front().find("camera_matrix");
}

// The joint covariance, with rows of zeros for the place of the reference, whose frame is that of
// the rig, and without those of boards.
void read_rig_covariance(const YamlValue& value, CameraFile& file) {
  const Eigen::MatrixXd joint = read_matrix(value);
  std::optional<KnownRig> rig = known_rig_of(file);
  if (!rig) value.fail_plainly("needs camera_from_rig of all cameras");
  const Eigen::Index size = rig->first_of_lens(rig->cameras.size()) - 6;
  const Eigen::Index of_boards = joint.rows() - size;
  if (joint.rows() != joint.cols() || of_boards < 0 || of_boards % 6 != 0)
    value.fail_plainly(
        fmt::format("must be square, with {} rows, and 6 for each board, got {} x {}", size,
                    joint.rows(), joint.cols()));
  if (const std::string defect = covariance_defect(joint); !defect.empty())
    value.fail_plainly(defect);
  if (!rig->reference())
    value.fail_plainly("needs a camera whose camera_from_rig is the identity: the reference");
  rig->set_joint_covariance(joint);
  file.rig_covariance = rig->covariance;
}

CameraFile read_rig_cameras(const YamlValue& top) {
  CameraFile file;
  file.format = "tagcal";
  std::set<std::string> names;
  const std::vector<YamlValue> items = top.at("cameras").items(1, limits::kMaxRigCameras);
  for (const YamlValue& item : items) {
    FileCamera camera;
    camera.name = item.at("name").text();
    if (!names.insert(camera.name).second) item.at("name").fail("must differ between cameras");
    camera.calibration = read_opencv_camera(item, {}, file.notes);
    read_uncertainty(item, camera.calibration);
    if (const auto pose = item.find("camera_from_rig")) camera.camera_from_rig = read_pose(*pose);
    if (const auto shift = item.find("imu_time_shift_s")) camera.imu_time_shift_s = shift->number();
    if (const auto overlaps = item.find("overlaps"))
      camera.overlaps = numbers_of_cameras(*overlaps, items.size());
    file.cameras.push_back(std::move(camera));
  }
  if (const auto frame = top.find("rig_frame")) {
    if (frame->text() != "imu") frame->fail("must be imu");
    file.rig_is_imu = true;
  }
  file.findings = read_findings(top);
  if (const auto joint = top.find("joint_covariance")) read_rig_covariance(*joint, file);
  const auto views = top.find("views");
  if (!views) return file;
  read_views(*views, file);
  const std::vector<YamlValue> listed = views->items(0, file.poses.size());
  for (std::size_t i = 0; i < listed.size(); ++i)
    if (const auto camera = listed[i].find("camera"))
      file.poses[i].camera =
          static_cast<std::size_t>(camera->whole(0, static_cast<int>(file.cameras.size()) - 1));
  return file;
}

FormatOutput write_tagcal(const CameraFile& file) {
  FormatOutput output;
  const bool is_rig = file.cameras.size() > 1;
  std::string text =
      "%YAML:1.0\n---\n" +
      (is_rig ? rig_keys(file, output.notes) : calibration_keys(file.cameras.front().calibration));
  if (!file.poses.empty()) text += "views:\n";
  std::set<std::string> names;
  for (std::size_t i = 0; i < file.poses.size(); ++i)
    text += image_line(file.poses[i].image, i, names) +
            pose_lines(file.poses[i].camera_from_world, "") +
            (is_rig ? fmt::format("     camera: {}\n", file.poses[i].camera) : "");
  if (!is_rig) note_no_rig(file, output.notes);
  if (!is_rig && !file.findings.empty())
    output.notes.emplace_back("dropped: the warnings of the rig");
  output.files = {{"", text}};
  return output;
}

}  // namespace tagcal::internal
