#include "tagcal/estimate/calibration/simpler_model_test.hpp"

#include <cmath>

#include "tagcal/estimate/calibration/calibration_seed.hpp"

namespace tagcal::internal {
namespace {

constexpr int kIterations = 100;
constexpr std::size_t kFewViews = 8;
constexpr double kCurved = 4;  // by which a cost may rise more slowly than its information says
constexpr double kSmallestCosine = 0.17;  // 80 degrees from the axis

// Of as many views, evenly spread.
Bundle some_views(const Bundle& bundle, std::size_t count) {
  Bundle some{bundle.model, bundle.image_size, bundle.free_values, {}, {}};
  const std::size_t n = bundle.views.size();
  for (std::size_t i = 0; i < std::min(count, n); ++i) {
    const std::size_t v = i * n / std::min(count, n);
    some.views.push_back(bundle.views[v]);
    some.camera_from_target.push_back(bundle.camera_from_target[v]);
  }
  return some;
}

// The same views with one focal length: from their poses, or from none where a fisheye has these
// beyond what a plain lens sees. No value where such a lens has no poses for them.
std::optional<Bundle> with_focal_length(const Bundle& bundle) {
  const Model& model = bundle.model->sibling("f");
  Bundle plain = with_model(bundle, model);
  if (well_in_front(bundle)) return plain;
  std::vector<CalibrationView> views;
  for (const ViewProblem& problem : bundle.views) {
    CalibrationView& view = views.emplace_back();
    view.problem = problem;
    for (std::size_t i = 0; i < problem.correspondences.size(); ++i) {
      view.ids.push_back({static_cast<int>(i), 0});
      view.seed.push_back(i);
    }
  }
  const auto start = find_start(model, bundle.image_size, views);
  if (!start) return std::nullopt;
  plain.free_values = start->free_values;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!start->camera_from_world[v]) return std::nullopt;
    plain.camera_from_target[v] = *start->camera_from_world[v];
  }
  return plain;
}

// What a plain lens says: a refusal, or where it is (no value: it does not explain the corners).
struct Asked {
  Observability refused;
  std::optional<Bundle> plain;
  double excess = 0;  // of its cost

  bool any() const { return refused.status != Status::ok || plain; }
};

// `most`: by which a plain lens may be worse and explain as well.
Asked ask(const Bundle& solved, double sigma, double most) {
  Asked asked;
  std::optional<Bundle> state = with_focal_length(solved);
  if (!state) return asked;
  const double cost = cost_of(solved);
  asked.excess = solve(*state, kIterations).cost - cost;
  Observability seen = observability(*state, sigma);
  if (seen.status == Status::focal_not_observable && asked.excess < most) {
    asked.refused = std::move(seen);
    return asked;
  }
  const Model& plain = solved.model->sibling(solved.model->num_free() > 5 ? "pinhole" : "f+c");
  if (solved.model->num_free() <= plain.num_free()) return asked;
  state = with_model(*state, plain);
  asked.excess = solve(*state, kIterations).cost - cost;
  if (asked.excess > most) return asked;
  seen = observability(*state, sigma);
  if (seen.status != Status::ok) asked.refused = std::move(seen);
  asked.plain = std::move(state);
  return asked;
}

// How far the plain lens is from the solved one, in squared standard deviations of the parameters
// that both have.
double distance_square(const Bundle& plain, const Bundle& solved,
                       const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> common;  // among those of the solved one
  std::vector<double> differences;
  for (std::size_t i = 0; i < plain.free_values.size(); ++i) {
    for (std::size_t j = 0; j < solved.free_values.size(); ++j) {
      if (plain.model->free()[i].lens_parameters[0] != solved.model->free()[j].lens_parameters[0])
        continue;
      common.push_back(static_cast<Eigen::Index>(j));
      differences.push_back(plain.free_values[i] - solved.free_values[j]);
    }
  }
  const Eigen::Map<const Eigen::VectorXd> difference(differences.data(),
                                                     static_cast<Eigen::Index>(differences.size()));
  const auto inverse = exact_inverse(covariance(common, common));
  return inverse ? difference.dot(*inverse * difference) : 0;
}

}  // namespace

std::optional<Observability> doubt_of_plain_lens(const Bundle& solved,
                                                 const Eigen::MatrixXd& covariance, double sigma) {
  const int more = solved.model->num_free() - 1;
  if (more <= 0) return std::nullopt;
  const double square = sigma * sigma;
  const double most = square * more * std::log(2.0 * num_corners(solved));
  if (solved.views.size() > kFewViews && !ask(some_views(solved, kFewViews), sigma, most).any())
    return std::nullopt;
  Asked asked = ask(solved, sigma, most);
  if (asked.refused.status != Status::ok) return asked.refused;
  if (!asked.plain || distance_square(*asked.plain, solved, covariance) <
                          kCurved * (asked.excess / square + kCurved * kCurved))
    return std::nullopt;
  asked.refused.status = Status::not_observable;
  asked.refused.reason = "not observable from these views: model " +
                         std::string(solved.model->name()) +
                         " describes the noise, and its standard deviations say nothing; model " +
                         std::string(asked.plain->model->name()) + " explains the corners as well";
  return asked.refused;
}

bool well_in_front(const Bundle& bundle) {
  if (bundle.model->lens_type() == LensType::perspective) return true;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    for (const Correspondence& c : bundle.views[v].correspondences) {
      const Eigen::Vector3d x = bundle.camera_from_target[v] * c.point;
      if (x.z() < kSmallestCosine * x.norm()) return false;
    }
  }
  return true;
}

Bundle with_model(const Bundle& bundle, const Model& model) {
  Bundle result = bundle;
  result.model = &model;
  result.free_values = model.free_values(bundle.lens());
  return result;
}

std::optional<LargerLens> larger_lens(const Bundle& solved, double sigma) {
  const Model& usual = solved.model->sibling("opencv5");
  if (solved.model->lens_type() != LensType::perspective ||
      solved.model->num_free() >= usual.num_free())
    return std::nullopt;
  const auto information = bundle_information(with_model(solved, usual));
  if (!information) return std::nullopt;
  const auto inverse = exact_inverse(information->halves[0] + information->halves[1]);
  if (!inverse) return std::nullopt;
  const Eigen::VectorXd gradient = information->gradients[0] + information->gradients[1];
  const double less = gradient.dot(*inverse * gradient);
  return LargerLens{less / (sigma * sigma), less / std::max(cost_of(solved), 1e-300)};
}

}  // namespace tagcal::internal
