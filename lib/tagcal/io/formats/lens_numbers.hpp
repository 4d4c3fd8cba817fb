#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// Readers and writers of all formats share these.

namespace tagcal::internal {

// Pixel centres at (0.5, 0.5), as COLMAP and nerfstudio have them, less those at (0, 0).
constexpr double kHalfPixel = 0.5;

// A lens by its first parameters, in the order of its kind; the others are those of the plain lens.
// Errors begin with `where`, "FILE: KEY".
Lens lens_of(const LensKind& kind, std::span<const double> parameters, const std::string& where);

FileCamera file_camera(const std::string& name, const Lens& lens, const ImageSize& size);

// "FILE: KEY", to begin an error with.
std::string place(const YamlValue& value, std::string_view key);

// A pose of a rotation matrix and a translation. Throws Error, naming `where`, for a reflection and
// other matrices that are no rotation, which messages call `what`.
Pose place_of_matrix(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                     const YamlValue& where, std::string_view what = "it");

// A pose of a quaternion and a translation. Throws Error, naming `where` and `what`, unless it is a
// unit quaternion.
Pose place_of_quaternion(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation,
                         const YamlValue& where, std::string_view what = "");

// Numbers of cameras of a file with so many.
std::vector<std::size_t> numbers_of_cameras(const YamlValue& list, std::size_t num_cameras);

// A file to be written.
struct OutputText {
  std::string name;  // in the folder; "": the file itself
  std::string text;
};

// The result of a format's writer.
struct FormatOutput {
  std::vector<OutputText> files;
  std::vector<std::string> notes;
};

// The 12 parameters of a Perspective lens. Throws Error with the format's name for other lenses,
// and a model of its own that may fit them.
std::span<const double> perspective_numbers(const FileCamera& camera, std::string_view format,
                                            std::string_view other_model = "fisheye4");
bool is_fisheye(const FileCamera& camera);

// Throws Error if a coefficient from index `first` on is not 0, because the format has no place for
// it; `lens` names that of the format, for example "kalibr's radtan lens (k1 k2 p1 p2)".
void need_zero_from(std::size_t first, std::span<const double> parameters, std::string_view lens);

// The name of a camera by number; cam0, cam1, .. without one.
std::string camera_name(const CameraFile& file, std::size_t camera);

// The only camera. Throws Error if there are several.
const FileCamera& only_camera(const CameraFile& file, std::string_view format);

// Notes on what a format has no place for.
void note_no_uncertainty(const CameraFile& file, std::vector<std::string>& notes);
void note_no_rig(const CameraFile& file, std::vector<std::string>& notes);
void note_no_poses(const CameraFile& file, std::vector<std::string>& notes);
// For formats that call their cameras cam0, cam1, ..
void note_numbered(const CameraFile& file, std::vector<std::string>& notes);

}  // namespace tagcal::internal
