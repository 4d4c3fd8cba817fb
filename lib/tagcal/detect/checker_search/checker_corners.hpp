#pragma once

#include <map>
#include <optional>
#include <vector>

#include "tagcal/detect/checker_search/checker_print.hpp"
#include "tagcal/detect/tag_fit/picture_processing.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect: the corners of one checkerboard in one picture.
namespace tagcal::internal {

struct CheckerCorner {
  Eigen::Vector2d at;
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
};

using CheckerCorners = std::map<CheckerCell, CheckerCorner>;

// A place on the board, in squares from the first corner, and its pixel.
struct CheckerPlace {
  Eigen::Vector2d on_board;
  Eigen::Vector2d at;
};

// Places by the corner of the board that is nearest to them, so that those near one corner are
// found without the others.
class PlacesByCell {
 public:
  PlacesByCell() = default;
  explicit PlacesByCell(const std::vector<CheckerPlace>& places);

  // Replaces the place at the same point of the board: a fitted corner its own seed.
  void put(const CheckerPlace& place);

  // The places within some squares of a corner along both axes, in the order in which they were
  // put.
  std::vector<CheckerPlace> near(const CheckerCell& cell, double reach) const;

 private:
  struct Numbered {
    std::size_t number;
    CheckerPlace place;
  };
  std::size_t count_ = 0;
  std::map<CheckerCell, std::vector<Numbered>> by_cell_;
};

class CheckerFitter {
 public:
  // Picture, print and camera (may be null) must outlive it.
  CheckerFitter(const ImageView8& image, const CheckerPrint& print, const Camera* camera);

  // Fits the corners that stand near enough to the known places to be predicted by a homography of
  // the nearest ones; corners that are found predict further ones. The fits are quick ones, which
  // fit_under_lens() completes.
  CheckerCorners fit(const std::vector<CheckerPlace>& known) const;

  // Fits the corners again, with the processing of the picture and under the camera or the lens
  // that they show together, if they determine it: bends are not estimated from each corner then.
  // Removes those whose fits fail.
  void fit_under_lens(CheckerCorners& corners) const;

  // Removes the corners that the lens of all does not explain. False if they do not determine one.
  bool drop_outliers(CheckerCorners& corners) const;

  // Fits known corners again under the camera that was given. Returns those whose fits succeed.
  CheckerCorners fit_again(const CheckerCorners& corners) const;

 private:
  std::optional<CornerFit> fit_one(const CheckerCell& cell, const PlacesByCell& known,
                                   TagFitOptions options) const;
  CameraProcessing processing_of(const CheckerCorners& corners, const PlacesByCell& places) const;

  const ImageView8& image_;
  const CheckerPrint& print_;
  const Camera* camera_;
};

// True if most corners were fitted, and enough of each outermost line.
bool is_verified(const CheckerCorners& corners, const CheckerPrint& print);

std::vector<Observation> observations_of(const CheckerCorners& corners, const Checkerboard& board);

}  // namespace tagcal::internal
