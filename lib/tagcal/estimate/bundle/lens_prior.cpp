#include "tagcal/estimate/bundle/lens_prior.hpp"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// One pseudo-observation z of standard deviation 1, and its gradient.
struct Term {
  double z = 0;
  VectorXd gradient;
};

// The free parameters as a prior sees them.
class Parameters {
 public:
  Parameters(const Model& model, std::span<const double> values, const ImageSize& size)
      : model_(model), values_(values), size_(size) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (role(i) == ParameterRole::focal_length) focal_.push_back(i);
  }

  std::vector<Term> terms() const {
    std::vector<Term> all;
    if (!focal_.empty()) all.push_back(focal_length());
    if (focal_.size() == 2) all.push_back(aspect_ratio());
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (role(i) == ParameterRole::principal_point) all.push_back(principal_point(i));
      if (role(i) == ParameterRole::radial || role(i) == ParameterRole::tangential)
        all.push_back(distortion(i));
      if (role(i) == ParameterRole::shape) all.push_back(shape(i));
    }
    return all;
  }

 private:
  ParameterRole role(std::size_t i) const { return model_.parameter(i).role; }
  Term zero() const { return {0, VectorXd::Zero(static_cast<Index>(values_.size()))}; }

  Term focal_length() const {
    Term term = zero();
    const double share = 1 / static_cast<double>(focal_.size()) / policy::kPriorLogFocal;
    for (const std::size_t i : focal_) {
      term.z += share * std::log(values_[i] / (policy::kPriorFocal * size_.width));
      term.gradient[static_cast<Index>(i)] = share / values_[i];
    }
    return term;
  }

  Term aspect_ratio() const {
    Term term = zero();
    term.z = std::log(values_[focal_[1]] / values_[focal_[0]]) / policy::kPriorAspect;
    term.gradient[static_cast<Index>(focal_[0])] = -1 / values_[focal_[0]] / policy::kPriorAspect;
    term.gradient[static_cast<Index>(focal_[1])] = 1 / values_[focal_[1]] / policy::kPriorAspect;
    return term;
  }

  Term principal_point(std::size_t i) const {
    const double sigma_px = policy::kPriorCentre * size_.width;
    const Eigen::Vector2d centre = image_centre(size_);
    Term term = zero();
    const bool is_x = model_.free()[i].lens_parameters.front() == kCx;
    term.z = (values_[i] - (is_x ? centre.x() : centre.y())) / sigma_px;
    term.gradient[static_cast<Index>(i)] = 1 / sigma_px;
    return term;
  }

  Term shape(std::size_t i) const {
    const LensParameter& parameter = model_.parameter(i);
    Term term = zero();
    term.z = (values_[i] - parameter.plain) / parameter.prior_sigma;
    term.gradient[static_cast<Index>(i)] = 1 / parameter.prior_sigma;
    return term;
  }

  // k s^p / width. The radius s of the image's corner depends on the focal lengths.
  Term distortion(std::size_t i) const {
    const LensParameter& parameter = model_.parameter(i);
    const double power = parameter.power == 0 ? 1 : 2 * std::abs(parameter.power);
    double focal = 0;
    for (const std::size_t f : focal_) focal += values_[f] / static_cast<double>(focal_.size());
    if (focal_.empty()) focal = policy::kPriorFocal * size_.width;  // held
    const double q = std::hypot(size_.width, size_.height) / 2 / focal;
    const double bend = q / policy::kPriorLargestRadius;
    const double s = q / std::sqrt(1 + bend * bend);
    const double by_unit = std::pow(s, power) / parameter.prior_sigma;
    Term term = zero();
    term.z = values_[i] * by_unit;
    term.gradient[static_cast<Index>(i)] = by_unit;
    // d log s / d log f = -1 / (1 + bend^2).
    for (const std::size_t f : focal_)
      term.gradient[static_cast<Index>(f)] =
          -term.z * power / (1 + bend * bend) / focal / static_cast<double>(focal_.size());
    return term;
  }

  const Model& model_;
  std::span<const double> values_;
  ImageSize size_;
  std::vector<std::size_t> focal_;  // indices of the free focal lengths
};

}  // namespace

StudentResidual student_residual(double z) {
  const double tail = z * z / policy::kPriorFreedom;
  // sqrt(n log(1 + z^2 / n)) / z, which is 1 at zero.
  const double ratio = tail > 0 ? std::sqrt(std::log1p(tail) / tail) : 1;
  return {z * ratio, 1 / (ratio * (1 + tail))};
}

PriorRows lens_prior(const Model& model, std::span<const double> free_values,
                     const ImageSize& size) {
  const std::vector<Term> terms = Parameters(model, free_values, size).terms();
  const auto n = static_cast<Index>(terms.size());
  PriorRows rows{VectorXd(n), Eigen::MatrixXd(n, static_cast<Index>(free_values.size()))};
  for (Index i = 0; i < n; ++i) {
    const Term& term = terms[static_cast<std::size_t>(i)];
    const StudentResidual residual = student_residual(term.z);
    rows.residuals[i] = residual.value;
    rows.by_parameters.row(i) = residual.by_z * term.gradient.transpose();
  }
  return rows;
}

UncertainCamera usual_lens(double focal_px, const ImageSize& size) {
  const Eigen::Vector2d centre = image_centre(size);
  UncertainCamera usual{
      &Model::named("opencv5"), {pinhole(focal_px, focal_px, centre.x(), centre.y()), size}, {}};
  const std::vector<double> values = usual.model->free_values(usual.camera.lens);
  const Eigen::MatrixXd rows = lens_prior(*usual.model, values, size).by_parameters;
  Eigen::MatrixXd without_mean = Eigen::MatrixXd::Identity(usual.num_free(), usual.num_free());
  without_mean.topLeftCorner<2, 2>().array() -= 1 / 2.;  // of fx and fy
  usual.covariance = without_mean * (rows.transpose() * rows).inverse() * without_mean;
  return usual;
}

}  // namespace tagcal::internal
