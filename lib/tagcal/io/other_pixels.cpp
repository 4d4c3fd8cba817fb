#include <algorithm>
#include <cassert>
#include <string>
#include <utility>
#include <vector>

#include "tagcal/io/camera_file.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// u' = scale u + shift, along x and y.
struct PixelMap {
  Vector2d scale, shift;

  PixelMap(const Camera& from, const Camera& to) {
    const auto p = parameters(from.lens), q = parameters(to.lens);
    scale = {q[0] / p[0], q[1] / p[1]};
    shift = Vector2d(q[2], q[3]) - scale.cwiseProduct(Vector2d(p[2], p[3]));
  }
  Vector2d operator()(const Vector2d& pixel) const { return scale.cwiseProduct(pixel) + shift; }
  // The scale of a parameter of the lens, by its number; fx, fy, cx and cy are the first ones.
  double scale_of(int parameter) const { return parameter < 4 ? scale[parameter % 2] : 1; }
};

// Matrix from the free parameters of a model to those on the other pixels, of the same model or of
// one that has all of them.
Eigen::MatrixXd parameters_on(const PixelMap& map, const Model& from, const Model& to) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(to.num_free(), from.num_free());
  for (int i = 0; i < to.num_free(); ++i) {
    const int target = to.free()[static_cast<std::size_t>(i)].lens_parameters.front();
    for (int j = 0; j < from.num_free(); ++j)
      if (std::ranges::count(from.free()[static_cast<std::size_t>(j)].lens_parameters, target) > 0)
        result(i, j) = map.scale_of(target);
  }
  return result;
}

SeenRegion region_on(const PixelMap& map, const SeenRegion& seen, const ImageSize& size) {
  constexpr double kBorder = -0.5;  // numeric: pixel (0, 0) is the centre of the first pixel
  const HalfSpace inside[] = {{Vector3d::UnitX(), kBorder},
                              {Vector3d::UnitY(), kBorder},
                              {-Vector3d::UnitX(), -(size.width + kBorder)},
                              {-Vector3d::UnitY(), -(size.height + kBorder)}};
  std::vector<Vector3d> corners;
  for (const Vector2d& corner : seen.hull()) corners.push_back(map(corner).homogeneous());
  std::vector<Vector2d> pixels;
  for (const Vector3d& corner : clip_polygon(corners, inside))
    pixels.emplace_back(corner.head<2>());
  return SeenRegion(size, pixels);
}

// A held f is a held fx and fy.
std::map<std::string, double> fixed_on(const std::map<std::string, double>& fixed,
                                       const Lens& lens) {
  std::map<std::string, double> result;
  const auto names = parameter_names(lens);
  for (std::size_t k = 0; k < names.size(); ++k)
    if (fixed.contains(std::string(names[k])) || (k < 2 && fixed.contains("f")))
      result[std::string(names[k])] = parameters(lens)[k];
  return result;
}

// Puts a camera on other pixels. Returns the matrix from the free parameters of its lens before to
// those after it, by the models of uncertain_camera; it is empty without a covariance.
Eigen::MatrixXd put_on_pixels(CalibrationFile& file, const Camera& camera) {
  const PixelMap map(file.camera, camera);
  const UncertainCamera known = uncertain_camera(file);
  if (file.seen.size() != ImageSize{}) file.seen = region_on(map, file.seen, camera.image_size);
  if (file.camera_error_px) *file.camera_error_px *= map.scale.maxCoeff();
  file.camera = camera;
  file.fixed = fixed_on(file.fixed, camera.lens);
  for (std::size_t k = 0; k < file.sigmas.size(); ++k)
    file.sigmas[k] *= map.scale_of(static_cast<int>(k));
  const std::string name = std::exchange(file.model, "");
  if (!known.model) return {};
  const Model& usual = full_model(camera.lens);
  const HeldModels models(file.fixed, usual.kind());
  const Model* model = &models.named(name);
  if (!model->contains(camera)) model = &models.named(usual.name());
  file.model = model->name();
  const Model& claim = known.model->contains(camera) ? *known.model : usual;
  const Eigen::MatrixXd by_old = parameters_on(map, *known.model, claim);
  file.claim_model = claim.name();
  file.claim_covariance = by_old * known.covariance * by_old.transpose();
  file.covariance = covariance_by(*model, {&claim, camera, file.claim_covariance});
  file.sigmas = lens_sigmas({model, camera, file.covariance});
  return by_old;
}

}  // namespace

void put_on_pixels(CameraFile& file, std::span<const Camera> cameras) {
  assert(cameras.size() == file.cameras.size());
  std::vector<Eigen::MatrixXd> by_old;
  Eigen::Index places = 6 * static_cast<Eigen::Index>(cameras.size());
  Eigen::Index rows = places, columns = places;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    by_old.push_back(put_on_pixels(file.cameras[c].calibration, cameras[c]));
    rows += by_old.back().rows();
    columns += by_old.back().cols();
  }
  if (file.rig_covariance.size() == 0) return;
  assert(file.rig_covariance.cols() == columns);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows, columns);
  all.topLeftCorner(places, places).setIdentity();
  rows = columns = places;
  for (const Eigen::MatrixXd& one : by_old) {
    all.block(rows, columns, one.rows(), one.cols()) = one;
    rows += one.rows();
    columns += one.cols();
  }
  file.rig_covariance = all * file.rig_covariance * all.transpose();
}

}  // namespace tagcal
