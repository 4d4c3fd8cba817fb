#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/handeye/handeye_bundle.hpp"
#include "tagcal/estimate/handeye/handeye_start.hpp"

namespace tagcal::internal {

// A view, with its pose by its corners alone. Corners and poses belong to the caller.
struct SeenView {
  std::string image;
  std::span<const Correspondence> corners;
  std::span<const Matrix2> covariance_px2;  // empty: by the common noise
  PoseEstimate own;
  std::span<const SeenPose> poses;  // of a view without corners
  Pose base_from_hand;
  std::optional<double> time_s;
  std::optional<RotationNumbers> rotation_numbers;
};

// What the views that can be used say, in their order.
class HandeyeSights {
 public:
  // Estimates the noise of the corners, and reports it and views without a pose.
  HandeyeSights(std::vector<SeenView> views, const UncertainCamera& camera,
                const HandeyeOptions& options, HandeyeEstimate& answer);

  // Collects the sights again, with the robot's poses of the path at an offset of time.
  void gather(double time_offset_s);
  // Keeps the sights that take part; the views of the others are `rejected`.
  void keep(std::span<const std::uint8_t> takes_part);

  HandeyeProblem& problem() { return problem_; }
  const HandeyeProblem& problem() const { return problem_; }
  std::size_t view_of(std::size_t sight) const { return index_[sight]; }
  const std::vector<std::size_t>& rejected() const { return rejected_; }
  const std::vector<std::size_t>& unusable() const { return unusable_; }
  const std::string& image_of(std::size_t view) const { return views_[view].image; }
  // The commonest reason why views have no pose, the sentence of its finding; "": not known.
  std::string why_unusable() const;
  std::vector<HandeyePair> pairs() const;

 private:
  bool has_corners() const;
  void set_scale();
  std::optional<HandeyeSight> sight_of(const SeenView& view, double time_offset_s) const;

  std::vector<SeenView> views_;
  HandeyeOptions options_;
  double sigma_px_ = 1;
  std::vector<std::size_t> index_;  // of the sights' views
  std::vector<std::size_t> rejected_, unusable_;
  HandeyeProblem problem_;
};

}  // namespace tagcal::internal
