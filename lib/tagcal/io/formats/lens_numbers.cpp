#include "tagcal/io/formats/lens_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/io/text/number_text.hpp"

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
    throw Error(fmt::format(
        "{} has no {}, which is {} here: calibrate with --model {}, or convert with it if it comes "
        "near enough",
        lens, Perspective::kParameters[i].name, number_text(parameters[i]),
        first <= 8 ? "opencv4" : "opencv5"));
  }
}

const FileCamera& only_camera(const CameraFile& file, std::string_view format) {
  if (file.cameras.size() == 1) return file.cameras.front();
  std::string names;
  for (const FileCamera& camera : file.cameras)
    names += (names.empty() ? "" : ", ") + shown(camera.name);
  throw Error(fmt::format("a file of {} holds one camera, and there are {}: {} (choose by IN:{})",
                          format, file.cameras.size(), names, shown(file.cameras.front().name)));
}

void note_no_uncertainty(const CameraFile& file, std::vector<std::string>& notes) {
  for (const FileCamera& camera : file.cameras) {
    const CalibrationFile& c = camera.calibration;
    if (c.sigmas.empty() && c.covariance.size() == 0 && c.seen.hull().empty()) continue;
    notes.emplace_back("dropped: standard deviations, covariance and seen region");
    return;
  }
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

}  // namespace tagcal::internal
