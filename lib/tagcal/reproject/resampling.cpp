#include "tagcal/reproject/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/reproject/kernels/reproject_dispatch.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/averaging.hpp"
#include "tagcal/reproject/rows/footprints.hpp"
#include "tagcal/reproject/rows/map_rows.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The values of a pixel, their number, and the kernels' kind.
template <typename T>
struct PixelOf {
  using Value = T;
  static constexpr int kValues = 1;
  static constexpr PixelKind kKind = sizeof(T) == 1 ? kGrey8 : kGrey16;
};
template <typename V>
struct PixelOf<std::array<V, 3>> {
  using Value = V;
  static constexpr int kValues = 3;
  static constexpr PixelKind kKind = sizeof(V) == 1 ? kColour8 : kColour16;
};

template <typename T>
class Resampler {
  using Value = typename PixelOf<T>::Value;
  static constexpr int kValues = PixelOf<T>::kValues;

 public:
  Resampler(const ImageView<T>& source, const MapRows& rows, const ResampleOptions& options,
            const T& border)
      : source_(source), rows_(rows), options_(options), border_(border) {
    const ReprojectKernels& kernels = fastest_reproject_kernels();
    constexpr PixelKind kKind = PixelOf<T>::kKind;
    row_ = options.interpolation == Interpolation::nearest    ? kernels.nearest[kKind]
           : options.interpolation == Interpolation::bilinear ? kernels.bilinear[kKind]
                                                              : kernels.lanczos[kKind];
    mean_ = options.interpolation == Interpolation::lanczos4 ? kernels.lanczos_mean[kKind]
                                                             : kernels.tent_mean[kKind];
  }

  Resampled<T> run() const {
    Resampled<T> result{Image<T>(rows_.size), Image8(rows_.size)};
    const int bands = (rows_.size.height + policy::kBlock - 1) / policy::kBlock;
    parallel_for(static_cast<std::size_t>(bands), options_.threads,
                 [&](std::size_t band) { fill_band(static_cast<int>(band), result); });
    return result;
  }

 private:
  const Value* values(const T* pixels) const { return reinterpret_cast<const Value*>(pixels); }

  void fill_band(int band, Resampled<T>& result) const {
    if (!averages()) return fill_plain_band(band, result);
    const double largest = std::max(source_.width(), source_.height());
    const Footprints footprints(rows_, band, largest);
    if (options_.interpolation == Interpolation::lanczos4)
      fill_band_by<LanczosKernel>(band, footprints, result);
    else
      fill_band_by<TentKernel>(band, footprints, result);
  }

  bool averages() const {
    return options_.area_correct && options_.interpolation != Interpolation::nearest;
  }

  // Calls work(v, x, y) for each row of a band, with the coordinates of its pixels.
  template <typename Work>
  void for_rows(int band, const Work& work) const {
    std::vector<float> x(static_cast<std::size_t>(rows_.size.width)), y(x.size());
    const int begin = band * policy::kBlock;
    const int end = std::min(begin + policy::kBlock, rows_.size.height);
    for (int v = begin; v < end; ++v) {
      rows_.fill(v, x.data(), y.data());
      work(v, x.data(), y.data());
    }
  }

  void fill_plain_band(int band, Resampled<T>& result) const {
    for_rows(band, [&](int v, const float* x, const float* y) {
      fill_plain({0, rows_.size.width}, v, x, y, result);
    });
  }

  struct Columns {
    int begin, end;
  };

  ResampleJob job_of(const Columns& columns, int v, const float* x, const float* y,
                     Resampled<T>& result) const {
    ResampleJob job;
    job.source = source_.row(0);
    job.stride = stride();
    job.width = source_.width();
    job.height = source_.height();
    job.x = x + columns.begin;
    job.y = y + columns.begin;
    job.num_pixels = columns.end - columns.begin;
    job.target = result.image.row(v) + columns.begin;
    job.seen = result.seen.row(v) + columns.begin;
    job.border = &border_;
    job.phases = lanczos_phases();
    job.profile = lanczos_profile();
    return job;
  }

  void fill_plain(const Columns& columns, int v, const float* x, const float* y,
                  Resampled<T>& result) const {
    row_(job_of(columns, v, x, y, result));
  }

  // Values from one row of the source to the next.
  std::ptrdiff_t stride() const {
    return (source_.height() > 1 ? source_.row(1) - source_.row(0) : source_.width()) * kValues;
  }

  template <typename Kernel>
  void fill_band_by(int band, const Footprints& footprints, Resampled<T>& result) const {
    Averager<Value, kValues, Kernel> averager(values(source_.row(0)), stride(), source_.size());
    const int blocks = (rows_.size.width + policy::kBlock - 1) / policy::kBlock;
    for_rows(band, [&](int v, const float* x, const float* y) {
      int begin = 0;  // of blocks that are plain so far
      for (int block = 0; block <= blocks; ++block) {
        if (block < blocks && footprints.is_plain(block)) continue;
        const int end = std::min(block * policy::kBlock, rows_.size.width);
        if (end > begin) fill_plain({begin, end}, v, x, y, result);
        begin = std::min(end + policy::kBlock, rows_.size.width);
        const Columns columns{end, begin};
        if (end < begin)
          fill_averaged(columns, job_of(columns, v, x, y, result), v, footprints, averager, result);
      }
    });
  }

  template <typename Averager>
  void fill_averaged(const Columns& columns, const ResampleJob& job, int v,
                     const Footprints& footprints, Averager& averager, Resampled<T>& result) const {
    const bool round = footprints.is_round(columns.begin / policy::kBlock);
    for (int u = columns.begin; u < columns.end; ++u) {
      const long i = u - columns.begin;
      const bool seen = is_seen(job.x[i], job.y[i]);
      job.seen[i] = seen ? 255 : 0;
      if (!seen) {
        result.image(u, v) = border_;
        continue;
      }
      const Footprint footprint =
          round ? Footprint{footprints.round_width(u, v), {0, 0}} : footprints.at(u, v);
      if (footprint.along.isZero(0) && mean_(job, i, static_cast<float>(footprint.width))) continue;
      write(averager, {job.x[i], job.y[i]}, footprint, result.image(u, v));
    }
  }

  bool is_seen(float x, float y) const {
    return x >= -0.5F && x < static_cast<float>(source_.width()) - 0.5F && y >= -0.5F &&
           y < static_cast<float>(source_.height()) - 0.5F;
  }

  template <typename Averager>
  void write(Averager& averager, const Eigen::Vector2d& pixel, const Footprint& footprint,
             T& target) const {
    double means[kValues];
    averager.at(pixel.x(), pixel.y(), footprint, means);
    Value* const to = reinterpret_cast<Value*>(&target);
    constexpr double kMost = std::numeric_limits<Value>::max();
    for (int k = 0; k < kValues; ++k)
      to[k] = static_cast<Value>(std::clamp(means[k] + 0.5, 0.0, kMost));
  }

  const ImageView<T>& source_;
  const MapRows& rows_;
  const ResampleOptions& options_;
  const T& border_;
  ReprojectKernels::ResampleRow row_;
  ReprojectKernels::MeanPixel mean_;
};

std::string text(const ImageSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

template <typename T>
void check(const ImageView<T>& picture) {
  if (picture.empty()) throw Error("reproject: the picture has no pixels");
}

}  // namespace

template <typename T>
Resampled<T> reproject(const ImageView<T>& picture, const Reprojection& reprojection,
                       const ResampleOptions& options, const std::type_identity_t<T>& border) {
  check(picture);
  if (picture.size() != reprojection.camera.image_size)
    throw Error("reproject: the picture must be " + text(reprojection.camera.image_size) +
                " pixels as its camera, got " + text(picture.size()));
  return Resampler<T>(picture, map_rows(reprojection), options, border).run();
}

template <typename T>
Resampled<T> remap(const ImageView<T>& picture, const PixelMap& map, const ResampleOptions& options,
                   const std::type_identity_t<T>& border) {
  check(picture);
  return Resampler<T>(picture, map_rows(map), options, border).run();
}

#define TAGCAL_INSTANTIATE(T)                                                               \
  template Resampled<T> reproject(const ImageView<T>&, const Reprojection&,                 \
                                  const ResampleOptions&, const T&);                        \
  template Resampled<T> remap(const ImageView<T>&, const PixelMap&, const ResampleOptions&, \
                              const T&);
TAGCAL_INSTANTIATE(std::uint8_t)
TAGCAL_INSTANTIATE(std::uint16_t)
TAGCAL_INSTANTIATE(Rgb)
TAGCAL_INSTANTIATE(Rgb16)
#undef TAGCAL_INSTANTIATE

}  // namespace tagcal
