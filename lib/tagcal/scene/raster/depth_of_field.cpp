#include "tagcal/scene/raster/depth_of_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "tagcal/scene/raster/depth.hpp"
#include "tagcal/scene/visibility/sheet_groups.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

// A pixel takes its blur from two levels whose variances differ by at most this, in px^2 or as a
// share: the mean variance is right, and an edge is off by 1 % of its contrast at most.
constexpr double kStepPx2 = 0.01;
constexpr double kStepShare = 0.5;
constexpr double kMostBlurPx = 100;  // what is blurred more is blurred by this
constexpr double kSharpPx = 0.02;    // what is blurred less is not: 1/200 of a pixel's own variance
constexpr double kReach = 5;         // standard deviations at which a Gaussian ends

using PixelBox = Eigen::AlignedBox2i;

// The variances in px^2 by which a sheet is blurred: by the sensor, and by a defocus of
// gain * (1 / z - 1 / z_sharp) pixels of standard deviation. With the focal length f and the image
// at the distance v = f z_sharp / (z_sharp - f), the disc of a point is
// aperture * v * |1 / z - 1 / z_sharp|, and v in pixels is the focal length of the camera model. A
// quarter of the diameter is the standard deviation in each coordinate.
class Blurring {
 public:
  Blurring(const Sensor& sensor, const Lens& lens)
      : sharp_(1 / sensor.focus->distance_m), sensor_(sensor.blur_px * sensor.blur_px) {
    const std::span<const double> p = parameters(lens);
    gain_ = sensor.focus->aperture_m * std::sqrt(p[0] * p[1]) / 4;
  }

  double variance(double inverse_depth) const {
    const double defocus = std::min(kMostBlurPx, std::abs(gain_ * (inverse_depth - sharp_)));
    return sensor_ + defocus * defocus;
  }

  // Levels for all variances between two inverse depths, from the smallest to the largest; one if
  // they are the same.
  std::vector<double> levels(double low, double high) const {
    const double most = std::max(variance(low), variance(high));
    std::vector<double> result = {variance(std::clamp(sharp_, low, high))};
    while (result.back() < most * (1 - kSame)) {
      const double v = result.back();
      result.push_back(std::min(most, v + std::max(kStepPx2, kStepShare * v)));
    }
    return result;
  }

 private:
  static constexpr double kSame = 1e-9;  // share of a variance

  double sharp_;
  double sensor_;
  double gain_ = 0;
};

// The inverse depths of a sheet: all of them lie between those of its corners.
class InverseDepth {
 public:
  explicit InverseDepth(const Sheet& sheet)
      : normal_(sheet.normal), offset_(sheet.normal.dot(sheet.corners.front())) {
    for (const Vector3d& x : sheet.corners) {
      const double inverse = x.z() > 0 ? 1 / x.z() : kNear;
      low = std::min(low, inverse);
      high = std::max(high, inverse);
    }
  }

  // Where a ray from the eye meets the plane of the sheet, or of the sheet's end that is closer.
  double at(const std::optional<Ray>& ray) const {
    const double along = ray ? offset_ / normal_.dot(ray->direction) : 0;
    return along > 0 ? std::clamp(1 / (along * ray->direction.z()), low, high) : low;
  }

  double low = kNear;
  double high = 0;

 private:
  static constexpr double kNear = 1e9;  // 1/m, of what reaches the eye

  Vector3d normal_;
  double offset_;
};

PixelBox grown(const PixelBox& box, int by) {
  return {box.min() - Vector2i::Constant(by), box.max() + Vector2i::Constant(by)};
}

PixelBox bounds(const Outlines& outlines, const PixelBox& limits) {
  Eigen::AlignedBox2d box;
  for (const Outlines::Edge& edge : outlines.edges()) box.extend(edge.from).extend(edge.to);
  const Vector2d low = limits.min().cast<double>(), high = limits.max().cast<double>();
  if (box.isEmpty()) return {};
  return {box.min().cwiseMax(low).cwiseMin(high).array().floor().cast<int>().matrix(),
          box.max().cwiseMax(low).cwiseMin(high).array().ceil().cast<int>().matrix()};
}

class Compositor {
 public:
  explicit Compositor(const Scene& scene)
      : scene_(scene),
        blurring_(scene.sensor, scene.camera.lens),
        image_(Vector2i(0, 0), Vector2i(size().width - 1, size().height - 1)),
        light_(size()),
        left_(size(), 1),
        levels_(size()),
        areas_(size()) {
    for (int y = 0; y < size().height; ++y)
      for (int x = 0; x < size().width; ++x)
        rays_.push_back(ray_in_camera(scene.camera.lens, Vector2d(x, y)));
  }

  // Puts a group of sheets behind what is there. A pixel that sees one of them has the blur of that
  // depth for all, so that their areas add up; another pixel has that of the plane of each.
  void add(const SheetGroup& group, const Painter& painter) {
    const std::vector<Sheet>& sheets = painter.shadows().sheets();
    double low = InverseDepth(sheets[group.front()]).low, high = 0;
    for (const std::size_t sheet : group) {
      low = std::min(low, InverseDepth(sheets[sheet]).low);
      high = std::max(high, InverseDepth(sheets[sheet]).high);
    }
    const bool is_shared = group.size() > 1;
    const ImageF seen =
        is_shared ? depth_of_sheets(painter.shadows(), group, scene_.camera) : ImageF();
    for (const std::size_t sheet : group) {
      const InverseDepth plane(sheets[sheet]);
      std::vector<double> variances;
      for (std::size_t i = 0; i < rays_.size(); ++i) {
        const double z = is_shared ? static_cast<double>(seen.pixels()[i]) : std::nan("");
        variances.push_back(
            blurring_.variance(std::isnan(z) ? plane.at(rays_[i]) : std::clamp(1 / z, low, high)));
      }
      add_sheet(painter.layer_of(sheet, group), variances, blurring_.levels(low, high));
    }
    finish_group();
  }

  ImageF finish() {
    const auto exposure = static_cast<float>(scene_.sensor.exposure);
    for (int y = 0; y < size().height; ++y)
      for (int x = 0; x < size().width; ++x)
        light_(x, y) =
            exposure * (light_(x, y) + left_(x, y) * static_cast<float>(scene_.background_level));
    return std::move(light_);
  }

 private:
  void finish_group() {
    for (int y = 0; y < size().height; ++y)
      for (int x = 0; x < size().width; ++x) {
        light_(x, y) += left_(x, y) * std::exchange(levels_(x, y), 0.0f);
        left_(x, y) *= 1 - std::clamp(std::exchange(areas_(x, y), 0.0f), 0.0f, 1.0f);
      }
  }

  // A variance, and those between which pixels take a share of it: 1 at it, 0 at the others.
  struct Tent {
    double before, peak, after;

    double operator()(double x) const {
      const double side = x < peak ? before : after;
      return std::max(0.0, 1 - (x - peak) / (side - peak));
    }
  };

  const ImageSize& size() const { return scene_.camera.image_size; }

  void add_sheet(const Layer& layer, const std::vector<double>& variances,
                 const std::vector<double>& levels) {
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const double before = i > 0 ? levels[i - 1] : -1;
      const double after = i + 1 < levels.size() ? levels[i + 1] : levels.back() + 1;
      add_level(layer, {before, levels[i], after}, variances);
    }
  }

  void add_level(Layer layer, const Tent& share, const std::vector<double>& variances) {
    const double sigma = std::sqrt(share.peak), blur_px = sigma < kSharpPx ? 0 : sigma;
    const int reach = static_cast<int>(std::ceil(kReach * blur_px)) + 1;
    PixelBox wanted;  // pixels that take a share
    for (int y = 0, i = 0; y < size().height; ++y)
      for (int x = 0; x < size().width; ++x, ++i)
        if (share(variances[static_cast<std::size_t>(i)]) > 0) wanted.extend(Vector2i(x, y));
    const PixelBox painted = bounds(layer.paper, grown(image_, 2 * reach));
    if (wanted.isEmpty() || painted.isEmpty()) return;
    const PixelBox box = grown(wanted, reach).intersection(grown(painted, reach));
    if (box.isEmpty()) return;
    const int scale = raster_scale(blur_px);
    const Vector2i extent = box.sizes() + Vector2i(1, 1);
    const Raster raster{scene_.camera.lens, box.min(), {extent.x(), extent.y()}, scale};
    const Vector2d offset = -scale * raster.first_pixel.cast<double>();
    layer.paper.transform(scale, offset);
    layer.ink.transform(scale, offset);
    const ImageF areas = Canvas({{layer.paper, {}, 1, 0, {}}}, 0, raster).sampled(blur_px, 1);
    const ImageF levels = Canvas({std::move(layer)}, 0, raster).sampled(blur_px, 1);
    const PixelBox seen = box.intersection(image_);
    for (int y = seen.min().y(); y <= seen.max().y(); ++y)
      for (int x = seen.min().x(); x <= seen.max().x(); ++x) {
        const auto weight =
            static_cast<float>(share(variances[static_cast<std::size_t>(y * size().width + x)]));
        levels_(x, y) += weight * levels(x - box.min().x(), y - box.min().y());
        areas_(x, y) += weight * areas(x - box.min().x(), y - box.min().y());
      }
  }

  const Scene& scene_;
  Blurring blurring_;
  PixelBox image_;
  std::vector<std::optional<Ray>> rays_;  // of the pixels, row by row
  ImageF light_;                          // of the groups so far
  ImageF left_;            // share of each pixel that they leave to what is behind them
  ImageF levels_, areas_;  // of the group: levels times areas, and areas
};

}  // namespace

ImageF render_in_focus(const Scene& scene, const TagFamilies& families,
                       const Pose& camera_from_world) {
  const Painter painter(scene, families, camera_from_world, 1);
  Compositor compositor(scene);
  for (const SheetGroup& group : groups_from_near(painter.shadows()))
    compositor.add(group, painter);
  return compositor.finish();
}

}  // namespace tagcal::internal
