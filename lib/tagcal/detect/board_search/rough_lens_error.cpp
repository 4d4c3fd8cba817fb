#include "tagcal/detect/board_search/rough_lens_error.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "tagcal/detect/tag_fit/straight_view.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kGrid = 7;  // places along a side of a tag at which a lens' error is evaluated
constexpr int kOnGrid = 2 * kGrid * kGrid;
constexpr int kTerms = 8 + tag_parameter::kNumBends;

// At the places of the grid, then at the corners.
using Displacement = Eigen::Matrix<double, kOnGrid + 8, 1>;

// Derivatives of a place by the homography's parameters and by the bends.
Eigen::Matrix<double, 2, kTerms> fitted_terms(const Vector2d& place) {
  const double x = place.x(), y = place.y();
  Eigen::Matrix<double, 2, kTerms> terms;
  terms.leftCols<8>() << x, y, 1, 0, 0, 0, x * x, x * y,  //
      0, 0, 0, x, y, 1, x * y, y * y;
  terms.rightCols<tag_parameter::kNumBends>() = bend_basis(x, y);
  return terms;
}

// Places on a grid over a tag in the straightened view of a lens, and the corners.
class TagPlaces {
 public:
  static std::optional<TagPlaces> of(const Lens& lens, const Quad& corners) {
    TagPlaces result;
    result.middle_ = centre_of(corners);
    result.scale_ = shortest_side(corners) / 2;
    const auto view = StraightView::about(lens, result.middle_, result.scale_);
    if (!view || !result.place(*view, corners)) return std::nullopt;
    for (const Vector2d& place : result.places_) {
      const auto pixel = view->pixel(place);
      if (!pixel) return std::nullopt;
      result.pixels_.push_back(*pixel);
    }
    return result;
  }

  // Displacement of the places if their pixels are straightened by another lens.
  std::optional<Displacement> under(const Lens& lens) const {
    const auto view = StraightView::about(lens, middle_, scale_);
    if (!view) return std::nullopt;
    Displacement result;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto place = view->place(pixels_[i]);
      if (!place) return std::nullopt;
      result.segment<2>(2 * static_cast<Eigen::Index>(i)) = *place - places_[i];
    }
    return result;
  }

  // Matrix from a displacement to what a fit leaves of it at the corners, px.
  Eigen::Matrix<double, 8, Displacement::RowsAtCompileTime> left_by_fit() const {
    Eigen::Matrix<double, Displacement::RowsAtCompileTime, kTerms> terms;
    for (std::size_t i = 0; i < places_.size(); ++i)
      terms.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = fitted_terms(places_[i]);
    const auto on_grid = terms.topRows<kOnGrid>();
    const Eigen::Matrix<double, kTerms, kOnGrid> fit =
        (on_grid.transpose() * on_grid).ldlt().solve(on_grid.transpose());
    Eigen::Matrix<double, 8, Displacement::RowsAtCompileTime> left;
    left << -terms.bottomRows<8>() * fit, Eigen::Matrix<double, 8, 8>::Identity();
    for (std::size_t i = 0; i < 4; ++i) {
      auto rows = left.middleRows<2>(2 * static_cast<Eigen::Index>(i));
      rows = (pixel_by_place_[i] * rows).eval();
    }
    return left;
  }

 private:
  bool place(const StraightView& view, const Quad& corners) {
    Quad at;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto place = view.place(corners[i]);
      const auto by_place = place ? view.pixel_by_place(*place) : std::nullopt;
      if (!by_place) return false;
      at[i] = *place;
      pixel_by_place_[i] = *by_place;
    }
    for (int j = 0; j < kGrid; ++j) {
      for (int i = 0; i < kGrid; ++i) {
        const double u = i / (kGrid - 1.0), v = j / (kGrid - 1.0);
        places_.emplace_back((1 - v) * ((1 - u) * at[0] + u * at[1]) +
                             v * ((1 - u) * at[3] + u * at[2]));
      }
    }
    places_.insert(places_.end(), at.begin(), at.end());
    return true;
  }

  Vector2d middle_;
  double scale_ = 1;
  std::vector<Vector2d> places_, pixels_;
  std::array<Eigen::Matrix2d, 4> pixel_by_place_;
};

}  // namespace

std::optional<Eigen::Matrix<double, 8, 8>> covariance_by_lens(const PanelLens& lens,
                                                              const Quad& corners) {
  const auto places = TagPlaces::of(lens.camera.lens, corners);
  if (!places) return std::nullopt;
  const auto left = places->left_by_fit();
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  for (const Lens& nearby : lens.nearby) {
    const auto moved = places->under(nearby);
    if (!moved) return std::nullopt;
    const Eigen::Matrix<double, 8, 1> bias = left * *moved / PanelLens::kNearby;
    covariance += bias * bias.transpose();
  }
  return covariance;
}

std::optional<Eigen::Matrix<double, 8, 1>> bias_between(const Lens& lens, const Lens& other,
                                                        const Quad& corners) {
  const auto places = TagPlaces::of(lens, corners);
  const auto moved = places ? places->under(other) : std::nullopt;
  if (!moved) return std::nullopt;
  return places->left_by_fit() * *moved;
}

}  // namespace tagcal::internal
