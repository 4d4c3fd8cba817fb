// Camera files of all programs: what was read is written in every format that takes it; ours gives
// the same numbers back. An input with a line `--8<--` is COLMAP's folder: cameras.txt above it,
// images.txt below.
#include <algorithm>

#include "fuzz/fuzz.hpp"
#include "tagcal/io/camera_file.hpp"

namespace {

using namespace tagcal;

void check_camera(const FileCamera& camera) {
  for (const double value : parameters(camera.calibration.camera.lens))
    fuzz::require(std::isfinite(value), "parameters are finite");
  if (camera.camera_from_rig)
    fuzz::require(camera.camera_from_rig->matrix().allFinite(), "places in a rig are finite");
  fuzz::require(uncertain_camera(camera.calibration).covariance.allFinite(), "claims are finite");
  const Camera& used = camera.calibration.camera;
  const std::optional<Ray> ray = ray_in_camera(used.lens, image_centre(used.image_size));
  if (!ray) return;
  fuzz::require(ray->direction.allFinite(), "rays are finite");
}

// Each camera can be had alone, by its name.
void check_one_camera(const std::filesystem::path& file, const CameraFile& all) {
  const std::string& name = all.cameras.back().name;
  const bool is_read = fuzz::is_accepted([&] {
    const CameraFile one = read_one_camera(file.string() + ":" + name);
    fuzz::require(one.cameras.size() == 1, "one camera is read alone");
  });
  fuzz::require(is_read || name.empty() || all.cameras.size() > 1, "a camera is read by its name");
}

bool are_equal(const CameraFile& a, const CameraFile& b) {
  if (a.cameras.size() != b.cameras.size()) return false;
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const auto p = parameters(a.cameras[i].calibration.camera.lens);
    const auto q = parameters(b.cameras[i].calibration.camera.lens);
    if (!std::ranges::equal(p, q)) return false;
    const MatrixX& claim = a.cameras[i].calibration.claim_covariance;
    const MatrixX& other = b.cameras[i].calibration.claim_covariance;
    if (claim.rows() != other.rows() || claim != other) return false;
  }
  return true;
}

// What a format takes can be read again; ours is the same.
void check_copy(const std::filesystem::path& out, const CameraFile& camera,
                std::string_view format) {
  if (!fuzz::is_accepted([&] { write_camera_file(out, camera, format); })) return;
  if (std::ranges::find(camera_formats(), format, &CameraFormat::name)->only_written) return;
  bool is_same = true;
  const bool is_read = fuzz::is_accepted([&] {
    const CameraFile again = read_camera_file(out);
    if (format == "tagcal") is_same = are_equal(camera, again);
  });
  fuzz::require(is_read, "a camera that was written can be read");
  fuzz::require(is_same, "and is the same");
}

std::filesystem::path written(const fuzz::Scratch& scratch, std::string_view text) {
  const auto [cameras, images] = fuzz::two_files(text);
  if (images.empty()) return scratch.write("camera", text);
  const std::filesystem::path folder = scratch.folder() / "colmap";
  std::filesystem::create_directories(folder);
  scratch.write("colmap/cameras.txt", cameras);
  scratch.write("colmap/images.txt", images);
  return folder;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch;
  const std::filesystem::path file = written(scratch, fuzz::text_of(data, size));
  bool is_recognised = false;
  fuzz::is_accepted([&] { is_recognised = is_camera_file(file); });
  fuzz::is_accepted([&] {
    for (const ImagePose& pose : read_poses(file))
      fuzz::require(pose.camera_from_world.matrix().allFinite(), "poses are finite");
  });
  fuzz::is_accepted([&] {
    const CameraFile read = read_camera_file(file);
    fuzz::require(!read.cameras.empty(), "a camera file has a camera");
    fuzz::require(is_recognised, "what is read is recognised");
    check_one_camera(file, read);
    std::ranges::for_each(read.cameras, check_camera);
    for (const ImagePose& pose : read.poses)
      fuzz::require(pose.camera_from_world.matrix().allFinite(), "poses are finite");

    for (const CameraFormat& format : camera_formats())
      check_copy(scratch.folder() / ("out_" + std::string(format.name)), read, format.name);
    check_copy(scratch.folder() / "out.xml", read, "opencv");
    check_copy(scratch.folder() / "out.json", read, "opencv");
  });
  return 0;
}
