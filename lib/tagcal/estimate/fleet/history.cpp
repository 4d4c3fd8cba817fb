#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tagcal/error.hpp"
#include "tagcal/estimate/fleet.hpp"
#include "tagcal/estimate/policy/fleet.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/uncertainty/policy/policy.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

void require_history(std::span<const UncertainCamera> calibrations, std::span<const double> keys) {
  constexpr std::size_t kFewest = 2;
  if (calibrations.size() < kFewest)
    throw Error(fmt::format("calibrations: must be two or more, got {}", calibrations.size()));
  if (keys.size() != calibrations.size())
    throw Error(fmt::format("keys: must be {}, one a calibration, got {}", calibrations.size(),
                            keys.size()));
  const UncertainCamera& first = calibrations.front();
  for (std::size_t k = 0; k < calibrations.size(); ++k) {
    const UncertainCamera& now = calibrations[k];
    const auto fail = [&](const std::string& must) {
      throw Error(fmt::format("calibration {}: {}", k + 1, must));
    };
    const LensKind &kind = kind_of(now.camera.lens), &kind_of_first = kind_of(first.camera.lens);
    const ImageSize &size = now.camera.image_size, &size_of_first = first.camera.image_size;
    if (!std::isfinite(keys[k])) fail("its key must be finite");
    if (!kind.is_central) fail("a parallel lens has no history");
    if (&kind != &kind_of_first)
      fail(fmt::format("must have a lens of the kind {} as the first, got {}", kind_of_first.name,
                       kind.name));
    if (!(size == size_of_first))
      fail(fmt::format("image size must be {}x{} as of the first, got {}x{}", size_of_first.width,
                       size_of_first.height, size.width, size.height));
    if (now.model == nullptr || now.covariance.size() == 0) fail("has no covariance");
    if (now.model->name() != first.model->name() || now.num_free() != first.num_free())
      fail(fmt::format("must have the model {} as the first, got {}: calibrate all by one --model",
                       first.model->name(), now.model->name()));
  }
}

// Rows that take a change of the free parameters to the reported changes in pixels.
class Effects {
 public:
  Effects(const UncertainCamera& camera, std::span<const Vector2d> samples)
      : image_(aligned_jacobian(camera, samples, kInfinitelyFar)) {
    const Model& model = *camera.model;
    const Index k = model.num_free();
    RowVectorXd of_distortion = RowVectorXd::Zero(k);
    for (Index i = 0; i < k; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const ParameterRole role = model.parameter(at).role;
      if (role == ParameterRole::focal_length || role == ParameterRole::principal_point)
        rows_.emplace_back(std::string(model.free()[at].name), RowVectorXd::Unit(k, i));
      else
        of_distortion[i] = 1;
    }
    if (of_distortion.isZero()) return;
    // Outwards where the distortion moves most by one standard deviation of each of its parameters.
    const MatrixXd rows = image_ * of_distortion.asDiagonal();
    const VectorXd variances = (rows * camera.covariance).cwiseProduct(rows).rowwise().sum();
    Index row = 0;
    double most = -1;
    for (Index i = 0; i + 1 < rows.rows(); i += 2)
      if (variances[i] + variances[i + 1] > most) {
        most = variances[i] + variances[i + 1];
        row = i;
      }
    const std::optional<Vector2d> out = outwards(camera, samples, row / 2);
    if (out) rows_.emplace_back("distortion", out->transpose() * rows.middleRows<2>(row));
  }

  std::vector<HistoryChange> parameters(const VectorXd& change, const MatrixXd& covariance) const {
    std::vector<HistoryChange> all;
    for (const auto& [name, row] : rows_)
      all.push_back({name, row.dot(change.transpose()), sigma(row, covariance)});
    return all;
  }

  // The largest displacement of a sample.
  HistoryChange image(const VectorXd& change, const MatrixXd& covariance) const {
    const VectorXd moved = image_ * change;
    HistoryChange largest{"image", 0, 0};
    for (Index i = 0; i + 1 < moved.size(); i += 2) {
      const Vector2d d = moved.segment<2>(i);
      if (!(d.norm() > largest.px)) continue;
      largest.px = d.norm();
      largest.sigma_px =
          sigma(RowVectorXd(d.normalized().transpose() * image_.middleRows<2>(i)), covariance);
    }
    return largest;
  }

 private:
  static double sigma(const RowVectorXd& row, const MatrixXd& covariance) {
    return std::sqrt(std::max(0.0, row.dot(row * covariance)));
  }

  // From the principal point to the sample of that number among those with a ray.
  static std::optional<Vector2d> outwards(const UncertainCamera& camera,
                                          std::span<const Vector2d> samples, Index number) {
    const auto centre = project(camera.camera.lens, Eigen::Vector3d::UnitZ());
    for (const Vector2d& sample : samples)
      if (const auto ray = ray_in_camera(camera.camera.lens, sample);
          ray && in_domain(camera.camera.lens, ray->direction) && number-- == 0 && centre)
        return (sample - *centre).normalized();
    return std::nullopt;
  }

  MatrixXd image_;
  std::vector<std::pair<std::string, RowVectorXd>> rows_;
};

// A trend with the noise that its residuals show.
struct Judged {
  Trend trend;
  double inflation = 1;  // of the variances
  double p_value = 1;
  double after = 0, before = 0;
};

Judged judged(const Trend& trend) {
  const auto p = static_cast<double>(trend.slopes.rows());
  const double freedom = trend.scatter_freedom;
  const double inflation = std::max(1.0, trend.scatter / freedom);
  return {trend, inflation, variance_ratio_tail(trend.chi_square[0] / (p * inflation), p, freedom)};
}

// The step with the largest chi-square, after one of the keys in ascending order.
Judged best_step(std::span<const UnitValues> units, std::span<const double> keys) {
  std::optional<Judged> best;
  int places = 0;
  for (std::size_t s = 1; s < units.size(); ++s) {
    if (!(keys[s] > keys[s - 1])) continue;
    ++places;
    MatrixX is_after = MatrixX::Zero(static_cast<Index>(units.size()), 1);
    is_after.bottomRows(static_cast<Index>(units.size() - s)).setOnes();
    Judged now = judged(*estimate_trend(units, is_after));
    now.after = keys[s - 1];
    now.before = keys[s];
    if (!best || now.trend.chi_square[0] > best->trend.chi_square[0]) best = now;
  }
  best->p_value = std::min(1.0, places * best->p_value);
  return *best;
}

HistoryFit fit_of(const Judged& found, const Effects& effects, double range) {
  const MatrixXd covariance = found.inflation * found.trend.covariances[0];
  const VectorXd slopes = found.trend.slopes.col(0);
  const double freedom = found.trend.scatter_freedom;
  HistoryFit fit;
  fit.p_value = found.p_value;
  fit.parameters = effects.parameters(slopes, covariance);
  fit.image = effects.image(range * slopes, range * range * covariance);
  fit.scatter = std::sqrt(found.trend.scatter / freedom);
  fit.p_scatter = chi_square_tail(found.trend.scatter, freedom);
  fit.after = found.after;
  fit.before = found.before;
  return fit;
}

HistoryVerdict verdict_of(const Judged& trend, const Judged& step, std::size_t num) {
  const bool is_trend = trend.p_value < policy::kFalseAlarm / 2;
  const bool is_step = step.p_value < policy::kFalseAlarm / 2;
  if (!is_trend && !is_step) return HistoryVerdict::stable;
  // Twice the log-likelihoods, at one noise, with that of the place of the step.
  const double inflation = std::min(trend.inflation, step.inflation);
  const bool is_line_likelier =
      trend.trend.scatter / inflation <=
      step.trend.scatter / inflation + 2 * std::log(static_cast<double>(num - 1));
  if (is_trend && (!is_step || is_line_likelier)) return HistoryVerdict::trend;
  return HistoryVerdict::change;
}

}  // namespace

std::string_view verdict_name(HistoryVerdict verdict) {
  static constexpr std::string_view kNames[] = {"stable", "trend", "change", "too_few"};
  return kNames[static_cast<std::size_t>(verdict)];
}

CameraHistory estimate_history(std::span<const UncertainCamera> calibrations,
                               std::span<const double> keys, std::span<const Vector2d> samples) {
  require_history(calibrations, keys);
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return keys[k]; });
  std::vector<UnitValues> units;
  std::vector<double> sorted;
  for (const std::size_t k : order) {
    const UncertainCamera& camera = calibrations[k];
    units.push_back({camera.model->free_values(camera.camera.lens), camera.covariance});
    sorted.push_back(keys[k]);
  }
  CameraHistory history;
  history.false_alarm = policy::kFalseAlarm;
  std::vector<double> different = sorted;
  different.erase(std::unique(different.begin(), different.end()), different.end());
  constexpr std::size_t kFewestKeys = 3;  // numeric: a line through two keys has no residual
  if (different.size() < kFewestKeys) return history;
  const auto line =
      estimate_trend(units, Eigen::Map<const VectorXd>(sorted.data(), std::ssize(sorted)));
  if (!line || line->scatter_freedom < policy::kFewestScatterFreedom) return history;
  Judged trend = judged(*line);
  trend.after = sorted.front();
  trend.before = sorted.back();
  const Judged step = best_step(units, sorted);
  history.verdict = verdict_of(trend, step, different.size());
  const Effects effects(calibrations[order.front()], samples);
  history.trend = fit_of(trend, effects, sorted.back() - sorted.front());
  history.step = fit_of(step, effects, 1);
  return history;
}

}  // namespace tagcal
