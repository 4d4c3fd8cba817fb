#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/reproject/rectify.hpp"

namespace tagcal::internal {
namespace {

// As cv::FileStorage reads it between quotes; it ends a text at any other byte (OpenCV 4.6).
std::string xml_text(std::string_view text) {
  constexpr std::string_view kMarkup = "<>&\"'";
  std::string escaped;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = byte >= 0x20 && byte != 0x7f && kMarkup.find(c) == kMarkup.npos;
    escaped += is_plain ? std::string(1, c) : fmt::format("&#x{:02x};", byte);
  }
  return escaped;
}

Eigen::MatrixXd row_of(std::span<const double> values) {
  return Eigen::RowVectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::Matrix3d camera_matrix(std::span<const double> p) {
  Eigen::Matrix3d matrix;
  matrix << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1;
  return matrix;
}

// A rotation vector and a translation per picture.
Eigen::MatrixXd extrinsic_parameters(const std::vector<ImagePose>& poses) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(poses.size()), 6);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose& pose = poses[i].camera_from_world;
    rows.row(static_cast<Eigen::Index>(i)) << log_rotation(pose.rotation()).transpose(),
        pose.translation().transpose();
  }
  return rows;
}

}  // namespace

void StorageText::whole(std::string_view key, int value) { add(key, fmt::to_string(value)); }

void StorageText::texts(std::string_view key, const std::vector<std::string>& texts) {
  const auto line = [](const std::string& text) {
    return fmt::format("  \"{}\"\n", xml_text(text));
  };
  if (kind_ == StorageKind::yaml)
    body_ += texts_yaml(key, texts);
  else if (kind_ == StorageKind::xml)
    add(key, "\n" + joined(texts, "", line));
  else
    add(key, "[ " + joined(texts, ", ", json_text) + " ]");
}

void StorageText::matrix(std::string_view key, const Eigen::MatrixXd& matrix, bool is_of_pixels) {
  if (kind_ == StorageKind::yaml) {
    body_ += matrix_yaml(key, matrix, 0, is_of_pixels);
    return;
  }
  const bool xml = kind_ == StorageKind::xml;
  std::string data;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      data += (data.empty() ? "" : xml ? " " : ", ") + dotted_number(matrix(row, column));
  const Eigen::Index columns = matrix.cols() / (is_of_pixels ? 2 : 1);
  if (xml)
    body_ += fmt::format(
        "<{0} type_id=\"opencv-matrix\">\n  <rows>{1}</rows>\n  <cols>{2}</cols>\n"
        "  <dt>{3}</dt>\n  <data>\n    {4}</data></{0}>\n",
        key, matrix.rows(), columns, is_of_pixels ? "\"2d\"" : "d", data);
  else
    add(key, fmt::format("{{ \"type_id\": \"opencv-matrix\", \"rows\": {}, \"cols\": {}, "
                         "\"dt\": \"{}\", \"data\": [ {} ] }}",
                         matrix.rows(), columns, is_of_pixels ? "2d" : "d", data));
}

std::string StorageText::text() const {
  switch (kind_) {
    case StorageKind::yaml:
      return "%YAML:1.0\n---\n" + body_;
    case StorageKind::xml:
      return "<?xml version=\"1.0\"?>\n<opencv_storage>\n" + body_ + "</opencv_storage>\n";
    case StorageKind::json:
      return "{\n" + body_ + "\n}\n";
  }
  return "";
}

void StorageText::add(std::string_view key, const std::string& value) {
  if (kind_ == StorageKind::yaml)
    body_ += fmt::format("{}: {}\n", key, value);
  else if (kind_ == StorageKind::xml)
    body_ += fmt::format("<{0}>{1}</{0}>\n", key, value);
  else
    body_ += fmt::format("{}    \"{}\": {}", body_.empty() ? "" : ",\n", key, value);
}

StorageKind storage_kind(std::string_view extension) {
  if (extension == ".xml" || extension == ".XML") return StorageKind::xml;
  if (extension == ".json" || extension == ".JSON") return StorageKind::json;
  return StorageKind::yaml;
}

namespace {

constexpr const char* kFisheyeNote =
    "the lens is a fisheye (fisheye_model: 1): use cv::fisheye, not cv::projectPoints";

// The matrix and the coefficients of a camera.
void add_lens(StorageText& storage, const FileCamera& camera, const char* matrix,
              const char* distortion) {
  if (!is_fisheye(camera)) perspective_numbers(camera, "opencv");  // throws for other lenses
  const CalibrationFile& calibration = camera.calibration;
  storage.matrix(matrix, camera_matrix(parameters(calibration.camera.lens)));
  storage.matrix(distortion, row_of(distortion_of(calibration.camera.lens, calibration.model)));
}

// M1, D1, M2, D2.
StorageText pair_intrinsics(const CameraFile& file, StorageKind kind) {
  const FileCamera &left = file.cameras[0], &right = file.cameras[1];
  const ImageSize &size = left.calibration.camera.image_size,
                  &other = right.calibration.camera.image_size;
  if (size != other)
    throw Error(fmt::format(
        "a stereo pair of opencv has one image size, and there are {}x{} and {}x{}: choose one "
        "camera by IN:{}",
        size.width, size.height, other.width, other.height, shown(left.name)));
  if (is_fisheye(left) != is_fisheye(right))
    throw Error(
        "a stereo pair of opencv has lenses of one kind, and one of these is a fisheye: "
        "--model fits another lens");
  StorageText storage(kind);
  storage.whole("image_width", size.width);
  storage.whole("image_height", size.height);
  add_lens(storage, left, "M1", "D1");
  add_lens(storage, right, "M2", "D2");
  if (is_fisheye(left)) storage.whole("fisheye_model", 1);
  return storage;
}

// R, T and, as cv::stereoCalibrate has them, E and F.
void add_pair_extrinsics(StorageText& storage, const CameraFile& file) {
  const FileCamera &left = file.cameras[0], &right = file.cameras[1];
  const Pose right_from_left = *right.camera_from_rig * left.camera_from_rig->inverse();
  const Eigen::Matrix3d r = right_from_left.rotation().toRotationMatrix();
  const Eigen::Vector3d& t = right_from_left.translation();
  storage.matrix("R", r);
  storage.matrix("T", t);
  if (is_fisheye(left)) return;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d essential = cross * r;
  Eigen::Matrix3d fundamental =
      camera_matrix(parameters(right.calibration.camera.lens)).inverse().transpose() * essential *
      camera_matrix(parameters(left.calibration.camera.lens)).inverse();
  if (fundamental(2, 2) != 0) fundamental /= fundamental(2, 2);
  storage.matrix("E", essential);
  storage.matrix("F", fundamental);
  if (!left.rectification) return;
  storage.matrix("R1", left.rectification->rotation);
  storage.matrix("R2", right.rectification->rotation);
  storage.matrix("P1", left.rectification->projection);
  storage.matrix("P2", right.rectification->projection);
  storage.matrix("Q", left.rectification->disparity_to_depth);
}

FormatOutput write_pair(const CameraFile& given, StorageKind kind, bool as_folder) {
  CameraFile file = given;
  set_rectification(file);
  FormatOutput output;
  output.notes.assign(file.notes.begin() + std::ssize(given.notes), file.notes.end());
  StorageText storage = pair_intrinsics(file, kind), own(kind);
  if (file.cameras[0].camera_from_rig && file.cameras[1].camera_from_rig)
    add_pair_extrinsics(as_folder ? own : storage, file);
  else
    output.notes.emplace_back("R and T are left out: the places of the cameras are not known");
  output.files = {{as_folder ? "intrinsics.yml" : "", storage.text()}};
  if (as_folder && !own.is_empty()) output.files.push_back({"extrinsics.yml", own.text()});
  if (is_fisheye(file.cameras[0])) output.notes.emplace_back(kFisheyeNote);
  output.notes.push_back(fmt::format("M1, D1 are {}, M2, D2 are {}", shown(file.cameras[0].name),
                                     shown(file.cameras[1].name)));
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace

FormatOutput write_opencv(const CameraFile& file, StorageKind kind, bool as_folder) {
  if (file.cameras.size() == 2) return write_pair(file, kind, as_folder);
  const FileCamera& camera = only_camera(file, "opencv");
  const ImageSize& size = camera.calibration.camera.image_size;
  FormatOutput output;
  StorageText storage(kind);
  storage.whole("image_width", size.width);
  storage.whole("image_height", size.height);
  add_lens(storage, camera, "camera_matrix", "distortion_coefficients");
  if (is_fisheye(camera)) {
    storage.whole("fisheye_model", 1);
    output.notes.emplace_back(kFisheyeNote);
  }
  if (!file.poses.empty()) {
    storage.matrix("extrinsic_parameters", extrinsic_parameters(file.poses));
    output.notes.emplace_back("dropped: the names of the pictures (extrinsic_parameters has none)");
  }
  note_no_uncertainty(file, output.notes);
  note_no_rig(file, output.notes);
  output.files = {{"", storage.text()}};
  return output;
}

CameraInfo camera_info(const FileCamera& camera, std::string_view format) {
  const bool fisheye = is_fisheye(camera);
  const Lens& lens = camera.calibration.camera.lens;
  if (!fisheye) perspective_numbers(camera, format);
  CameraInfo info;
  info.distortion =
      distortion_of(lens, camera.calibration.model == "opencv8" ? "opencv8" : "opencv5");
  info.model = fisheye                       ? "equidistant"
               : info.distortion.size() == 8 ? "rational_polynomial"
                                             : "plumb_bob";
  info.camera = camera_matrix(parameters(lens));
  info.rectification.setIdentity();
  info.projection << info.camera, Eigen::Vector3d::Zero();
  if (camera.rectification) {
    info.rectification = camera.rectification->rotation;
    info.projection = camera.rectification->projection;
  }
  return info;
}

FormatOutput write_ros(const CameraFile& file) {
  const FileCamera& camera = only_camera(file, "ros");
  const CameraInfo info = camera_info(camera, "ros");
  const ImageSize& size = camera.calibration.camera.image_size;
  FormatOutput output;
  output.files = {{"", fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n"
                                   "camera_matrix:\n  rows: 3\n  cols: 3\n  data: {}\n"
                                   "distortion_model: {}\n"
                                   "distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: {}\n"
                                   "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: {}\n"
                                   "projection_matrix:\n  rows: 3\n  cols: 4\n  data: {}\n",
                                   size.width, size.height,
                                   text_yaml(camera.name.empty() ? "camera" : camera.name),
                                   dotted_list(std::span(info.camera.data(), 9)), info.model,
                                   info.distortion.size(), dotted_list(info.distortion),
                                   dotted_list(std::span(info.rectification.data(), 9)),
                                   dotted_list(std::span(info.projection.data(), 12)))}};
  if (!camera.rectification) {
    output.notes.emplace_back(
        "the rectification is the identity, the projection that of the camera matrix");
    note_no_rig(file, output.notes);
  }
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

void set_rectification(CameraFile& file) {
  if (file.cameras.size() != 2) return;
  KnownRig rig;
  for (const FileCamera& camera : file.cameras) {
    if (!camera.camera_from_rig) return;
    rig.cameras.push_back(
        {camera.name, {nullptr, camera.calibration.camera, {}}, *camera.camera_from_rig, {}});
  }
  try {
    const RectifiedPair pair = rectify(rig, 0, 1, {.alpha = 0});
    for (std::size_t k = 0; k < 2; ++k)
      file.cameras[k].rectification =
          FileCamera::Rectification{pair.camera_from_rectified[k].rotation_matrix().transpose(),
                                    projection_matrix(pair, k), disparity_to_depth(pair)};
  } catch (const Error& error) {
    file.notes.push_back(std::string("the pair is not rectified: ") + error.what());
  }
}

}  // namespace tagcal::internal
