// Calibrations of structured random data sets.
#include <iterator>

#include "fuzz/fuzz.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace {

using namespace tagcal;

constexpr const char* kModels[] = {"",        "weak",    "f",       "radial1",
                                   "radial2", "opencv4", "opencv5", "fisheye4",
                                   "ds",      "eucm",    "auto",    "no such model"};

View view_of(fuzz::Bytes& bytes, const Camera& camera, const std::vector<TargetPoint>& points,
             int index) {
  View view{"view" + std::to_string(index), {}};
  const Pose pose(exp_rotation({bytes.number(-2, 2), bytes.number(-2, 2), bytes.number(-4, 4)}),
                  {bytes.number(-0.5, 0.5), bytes.number(-0.5, 0.5), bytes.number(0.1, 3)});
  const double noise = bytes.flag() ? bytes.number(0, 3) : 0.1;
  const unsigned spoil = bytes.byte();
  for (const TargetPoint& point : points) {
    const auto projected = project(camera.lens, pose * point.position);
    if (!projected) continue;
    Observation seen{point.id,
                     *projected + noise * Eigen::Vector2d(bytes.number(-1, 1), bytes.number(-1, 1)),
                     {}};
    if (spoil > 240) seen.pixel.x() = bytes.wild(0, camera.image_size.width);
    if (spoil % 4 == 1) seen.covariance_px2 = Matrix2::Identity() * bytes.number(1e-4, 1);
    view.observations.push_back(seen);
  }
  return view;
}

Dataset dataset_of(fuzz::Bytes& bytes) {
  Dataset data;
  data.image_size = {bytes.whole(20, 2000), bytes.whole(20, 2000)};
  const double f = bytes.number(0.3, 4) * data.image_size.width;
  const Eigen::Vector2d c = image_centre(data.image_size);
  const double k1 = bytes.number(-0.5, 0.5);
  const bool is_fisheye = bytes.flag();
  Camera camera{pinhole(f, f, c.x(), c.y()), data.image_size};
  if (is_fisheye)
    camera.lens = Fisheye({f, f, c.x(), c.y(), k1, 0, 0, 0});
  else
    camera.lens = Perspective({f, f, c.x(), c.y(), k1, 0, 0, 0, 0, 0, 0, 0});
  data.boards.push_back(
      {bytes.flag() ? make_board(AprilGrid{2, 2, 0.1, 0.3})
                    : make_board(Checkerboard{
                          .columns = 4, .rows = 3, .column_spacing = 0.05, .row_spacing = 0.05}),
       Pose()});
  const std::vector<TargetPoint> points = target_points(data.boards.front().board);
  const int num_views = bytes.byte() % 9;
  for (int i = 0; i < num_views; ++i) data.views.push_back(view_of(bytes, camera, points, i));
  if (bytes.byte() % 8 == 1 && num_views > 1) data.views[1] = data.views[0];
  return data;
}

void check_calibration(const Calibration& calibration) {
  bool has_reason = false;
  for (const Finding& finding : calibration.findings)
    has_reason = has_reason || finding.severity == Severity::refusal;
  if (!is_answer(calibration.status)) {
    fuzz::require(has_reason, "a refusal has a reason");
    return;
  }
  fuzz::require(!has_reason, "an answer has no refusal");
  fuzz::require(calibration.camera.has_value(), "an answer has a camera");
  for (const double value : parameters(calibration.camera->lens))
    fuzz::require(std::isfinite(value), "parameters are finite");
  for (const double sigma : calibration.sigmas) fuzz::require(sigma >= 0, "sd are not negative");
  fuzz::require(calibration.claim.has_value() == (calibration.model != "weak"),
                "all models but weak have a claim");
  if (calibration.claim)
    fuzz::require(covariance_defect(calibration.claim->covariance).empty(),
                  "the claim is a covariance, as the reader of its file demands");
  fuzz::require(std::isfinite(calibration.rms_px), "residuals are finite");
  for (const CalibratedView& view : calibration.views)
    fuzz::require(view.camera_from_world.matrix().allFinite(), "poses are finite");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  CalibrateOptions options;
  options.model = kModels[bytes.byte() % std::size(kModels)];
  const unsigned flags = bytes.byte();
  options.reject_outliers = flags % 2 == 0;
  options.board_warp = (flags & 6U) == 6;
  if ((flags & 24U) == 24) options.fixed["f"] = bytes.wild(100, 1000);
  if ((flags & 32U) != 0) options.sigma_px = bytes.number(0, 1);
  if ((flags & 192U) == 192) options.start_focal_px = bytes.wild(10, 3000);
  Dataset dataset;
  if (!fuzz::is_accepted([&] { dataset = dataset_of(bytes); })) return 0;
  fuzz::is_accepted([&] { check_calibration(calibrate(dataset, options)); });
  return 0;
}
