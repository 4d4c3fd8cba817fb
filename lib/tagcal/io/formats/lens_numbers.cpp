#include "tagcal/io/formats/lens_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
Lens lens_of(const LensKind& kind, std::span<const double> given, const std::string& where) {
  if (given.size() > kind.parameters.size())
    throw Error(fmt::format("{}: must have at most {} parameters, got {}", where,
                            kind.parameters.size(), given.size()));
  std::vector<double> all(given.begin(), given.end());
  while (all.size() < kind.parameters.size()) all.push_back(kind.parameters[all.size()].plain);
  try {
    return make_lens(kind, all);
  } catch (const Error& error) {
    throw Error(where + ": " + error.what());
  }
}

FileCamera file_camera(const std::string& name, const Lens& lens, const ImageSize& size) {
  FileCamera camera;
  camera.name = name;
  camera.calibration.camera = {lens, size};
  return camera;
}

std::string place(const YamlValue& value, std::string_view key) {
  return fmt::format("{}: {}{}{}", value.file(), value.path(), value.path().empty() ? "" : ".",
                     key);
}

Pose place_of_matrix(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                     const YamlValue& where, std::string_view what) {
  return where.within([&] { return Pose(rotation_from_matrix(rotation, what), translation); });
}

Pose place_of_quaternion(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation,
                         const YamlValue& where, std::string_view what) {
  if (!(std::abs(rotation.norm() - 1) <= kRotationTolerance))
    where.fail_plainly(fmt::format("{}must be a unit quaternion, got one of length {:.6g}", what,
                                   rotation.norm()));
  return {rotation, translation};
}

std::vector<std::size_t> numbers_of_cameras(const YamlValue& list, std::size_t num_cameras) {
  std::vector<std::size_t> numbers;
  for (const YamlValue& item : list.items(0, num_cameras))
    numbers.push_back(static_cast<std::size_t>(item.whole(0, static_cast<int>(num_cameras) - 1)));
  return numbers;
}

std::span<const double> perspective_numbers(const FileCamera& camera, std::string_view format,
                                            std::string_view other_model) {
  const Lens& lens = camera.calibration.camera.lens;
  if (const auto* perspective = std::get_if<Perspective>(&lens)) return perspective->parameters();
  const LensKind& kind = kind_of(lens);
  std::string advice;
  if (kind.is_central)
    advice = fmt::format(": --model {} fits one that it has{}", other_model,
                         other_model == "fisheye4" ? "" : ", unless the view is wide");
  throw Error(fmt::format("{} has no {} lens{}", format,
                          is_fisheye(camera) ? "fisheye (Kannala-Brandt)" : kind.name, advice));
}

bool is_fisheye(const FileCamera& camera) {
  return std::holds_alternative<Fisheye>(camera.calibration.camera.lens);
}

void need_zero_from(std::size_t first, std::span<const double> parameters, std::string_view lens) {
  for (std::size_t i = first; i < parameters.size(); ++i) {
    if (parameters[i] == 0) continue;
    throw Error(
        fmt::format("{0} has no {1}, which is {2} here: convert --model {3} fits a lens without "
                    "it, or calibrate with --model {3}",
                    lens, Perspective::kParameters[i].name, number_text(parameters[i]),
                    first <= 8 ? "opencv4" : "opencv5"));
  }
}

std::string camera_name(const CameraFile& file, std::size_t camera) {
  const std::string& name = file.cameras[camera].name;
  return name.empty() ? fmt::format("cam{}", camera) : name;
}

const FileCamera& only_camera(const CameraFile& file, std::string_view format) {
  if (file.cameras.size() == 1) return file.cameras.front();
  const std::string names =
      joined(file.cameras, ", ", [](const FileCamera& camera) { return shown(camera.name); });
  throw Error(fmt::format("a file of {} holds one camera, and there are {}: {} (choose by IN:{})",
                          format, file.cameras.size(), names, shown(file.cameras.front().name)));
}

void note_no_uncertainty(const CameraFile& file, std::vector<std::string>& notes) {
  bool has_uncertainty = file.rig_covariance.size() > 0, has_findings = !file.findings.empty();
  for (const FileCamera& camera : file.cameras) {
    const CalibrationFile& c = camera.calibration;
    has_uncertainty |= !c.sigmas.empty() || c.covariance.size() > 0 || !c.seen.hull().empty();
    has_findings |= !c.findings.empty();
  }
  if (has_uncertainty)
    notes.emplace_back("dropped: standard deviations, covariance and seen region");
  if (has_findings) notes.emplace_back("dropped: the warnings of the calibration");
}

void note_no_rig(const CameraFile& file, std::vector<std::string>& notes) {
  for (const FileCamera& camera : file.cameras) {
    if (!camera.camera_from_rig) continue;
    const Pose& pose = *camera.camera_from_rig;
    if (minus(pose, Pose()).norm() == 0) continue;
    notes.emplace_back("dropped: the place of the camera in its rig");
    return;
  }
}

void note_no_poses(const CameraFile& file, std::vector<std::string>& notes) {
  if (file.poses.empty()) return;
  notes.push_back(fmt::format("dropped: the poses of {} pictures", file.poses.size()));
}

void note_numbered(const CameraFile& file, std::vector<std::string>& notes) {
  std::string numbers, names;
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    numbers += fmt::format("{}cam{}", i == 0 ? "" : ", ", i);
    names += (i == 0 ? "" : ", ") + shown(camera_name(file, i));
  }
  if (names != numbers)
    notes.push_back(
        fmt::format("{} {} {}", numbers, file.cameras.size() == 1 ? "is" : "are", names));
}

}  // namespace tagcal::internal
