#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"

namespace tagcal::internal {

bool has_wpilib_keys(const YamlValue& top) {
  const auto matrix = top.find("camera_matrix"), distortion = top.find("distortion_coefficients");
  return matrix && matrix->is_list() && distortion && distortion->is_list();
}

CameraFile read_wpilib(const YamlValue& top) {
  const YamlValue matrix = top.at("camera_matrix"), distortion = top.at("distortion_coefficients");
  const std::vector<double> k = matrix.numbers(9);
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    matrix.fail_plainly("must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  const std::vector<double> d = distortion.numbers(4, 14);
  std::vector<double> p = {k[0], k[4], k[2], k[5]};
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (i < 8) p.push_back(d[i]);
    if (i >= 8 && d[i] != 0)
      distortion.fail_plainly(fmt::format(
          "coefficient {} (thin prism, tilt) must be 0: no lens here has it, got {}", i + 1, d[i]));
  }
  CameraFile file;
  file.format = "wpilib";
  file.cameras.push_back(
      file_camera("", lens_of(kind_of<Perspective>(), p, place(top, "camera_matrix")), {}));
  return file;
}

FormatOutput write_wpilib(const CameraFile& file) {
  const FileCamera& camera = only_camera(file, "wpilib");
  const std::span<const double> p = perspective_numbers(camera, "wpilib", "opencv8");
  const double matrix[] = {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
  FormatOutput output;
  output.files = {
      {"", fmt::format("{{\n  \"camera_matrix\": {},\n  \"distortion_coefficients\": {}\n}}\n",
                       dotted_list(matrix), dotted_list(p.subspan(4)))}};
  output.notes.emplace_back("dropped: the size of the pictures, which the format has no key for");
  note_no_uncertainty(file, output.notes);
  note_no_rig(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
