#include "tagcal/estimate/pose/shifted_tag_test.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Residuals of exact data are rounding, which is correlated.
constexpr double kLeastVariancePx2 = kLeastPoseSigmaPx * kLeastPoseSigmaPx;

struct GroupPoints {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Vector2d> residuals_px;  // projected - observed
  std::vector<Matrix2> whitening;

  // Returns the group with its image shifted.
  GroupPoints moved_by(const Vector2d& shift_px) const {
    GroupPoints result = *this;
    for (Vector2d& pixel : result.pixels) pixel += shift_px;
    return result;
  }
};

std::map<int, GroupPoints> by_group(const PoseProblem& problem, std::span<const int> groups,
                                    const Lens& lens, const ViewState& state) {
  const ViewPoints view = problem.view();
  ViewResiduals residuals(lens, view);
  residuals.at(state);
  std::map<int, GroupPoints> result;
  for (std::size_t i = 0; i < view.size(); ++i) {
    GroupPoints& group = result[groups[i]];
    group.points.push_back(view.points[i]);
    group.pixels.push_back(view.pixels[i]);
    group.residuals_px.push_back(residuals.projected()[i] - view.pixels[i]);
    if (!view.whitening.empty()) group.whitening.push_back(view.whitening[i]);
  }
  return result;
}

// J'r of a group.
template <int N>
Eigen::Matrix<double, N, 1> gradient_of(const GroupPoints& group, const Lens& lens,
                                        const ViewState& state) {
  NormalEquations<N> equations;
  ViewSums(lens, {group.points, group.pixels, group.whitening}).at(state, equations);
  return equations.gradient;
}

// Decrease of the sum of squares of all points if the group may shift in the image. The normal
// equations get two more unknowns, and only these have a gradient at the minimum.
template <int N>
double gain_of_shift(const GroupPoints& group, const Eigen::LLT<Eigen::Matrix<double, N, N>>& all,
                     const Lens& lens, const ViewState& state) {
  const Eigen::Matrix<double, N, 1> here = gradient_of<N>(group, lens, state);
  Eigen::Matrix<double, N, 2> mixed;
  for (int k = 0; k < 2; ++k)
    mixed.col(k) = gradient_of<N>(group.moved_by(-Vector2d::Unit(k)), lens, state) - here;
  Matrix2d information = Matrix2d::Zero();
  Vector2d gradient = Vector2d::Zero();
  for (std::size_t i = 0; i < group.points.size(); ++i) {
    const Matrix2d w =
        group.whitening.empty() ? Matrix2d(Matrix2d::Identity()) : Matrix2d(group.whitening[i]);
    information += w.transpose() * w;
    gradient += w.transpose() * w * group.residuals_px[i];
  }
  const auto solved = Matrix2d(information - mixed.transpose() * all.solve(mixed)).llt();
  return solved.info() == Eigen::Success ? gradient.dot(solved.solve(gradient)) : 0;
}

}  // namespace

template <int N>
std::optional<int> shifted_tag(const PoseProblem& problem, std::span<const int> groups,
                               const Lens& lens, const ViewState& state) {
  NormalEquations<N> all;
  if (ViewSums sums(lens, problem.view()); !sums.at(state, all)) return std::nullopt;
  using MatrixN = Eigen::Matrix<double, N, N>;
  const Eigen::LLT<MatrixN> information(
      MatrixN(all.information.template selfadjointView<Eigen::Upper>()));
  if (information.info() != Eigen::Success) return std::nullopt;
  const double freedom = 2 * static_cast<double>(problem.size()) - N - 2;
  double largest = policy::kSignificant;
  std::optional<int> shifted;
  for (const auto& [id, members] : by_group(problem, groups, lens, state)) {
    const double remaining = freedom + 2 - 2 * static_cast<double>(members.points.size());
    if (remaining < policy::kFewestDegreesOfFreedom) continue;
    const double gain = std::min(gain_of_shift<N>(members, information, lens, state), all.cost);
    const double variance = std::max((all.cost - gain) / freedom, kLeastVariancePx2);
    const double score = variance_ratio_score(gain / 2 / variance, 2, freedom);
    if (!(score > largest)) continue;
    largest = score;
    shifted = id;
  }
  return shifted;
}

template std::optional<int> shifted_tag<6>(const PoseProblem&, std::span<const int>, const Lens&,
                                           const ViewState&);
template std::optional<int> shifted_tag<7>(const PoseProblem&, std::span<const int>, const Lens&,
                                           const ViewState&);

}  // namespace tagcal::internal
