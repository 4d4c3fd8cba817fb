// Is a calibration still valid: false alarms, power, what changed, and rigs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "check_worlds.hpp"
#include "finding_cases.hpp"
#include "rig_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "tagcal/estimate/view_correspondences.hpp"

namespace tagcal {
namespace {

WorldOptions pictures(int count) {
  WorldOptions options;
  options.num_views = count;
  return options;
}

Lens with(double focal_share, double centre_px, double k1 = 0) {
  auto p = std::get<Perspective>(opencv5_lens()).parameters();
  p[0] *= 1 + focal_share;
  p[1] *= 1 + focal_share;
  p[2] += centre_px;
  p[4] += k1;
  return Perspective(p);
}

TEST(CheckCamera, RaisesNoMoreFalseAlarmsThanItStates) {
  const int num_worlds = 2000;
  for (const int num_views : {2, 5, 15}) {
    int alarms = 0, valid = 0;
    double sum = 0, squares = 0;
    for (int i = 0; i < num_worlds; ++i) {
      const auto seed = static_cast<std::uint64_t>(1000 + i);
      Random random(seed);
      const UncertainCamera known = calibrated(opencv5_lens(), random);
      const CameraCheck check =
          check_camera(make_world(opencv5_lens(), seed, pictures(num_views)), known);
      alarms += check.verdict == CheckVerdict::changed;
      valid += check.verdict == CheckVerdict::valid;
      sum += check.in_sigmas;
      squares += check.in_sigmas * check.in_sigmas;
    }
    std::printf("%d views: %d false alarms, %d valid of %d, score %.2f +- %.2f\n", num_views,
                alarms, valid, num_worlds, sum / num_worlds,
                std::sqrt(squares / num_worlds - sum * sum / num_worlds / num_worlds));
    EXPECT_LE(alarms, 0.012 * num_worlds) << num_views;
  }
}

// The smallest change of a kind that the pictures say they would show, times a factor, is made; one
// sign after the other. Counts what is found, and of which kind it is called.
struct Found {
  int changes = 0, found = 0, right_kind = 0;
};

std::map<ChangeKind, Found> found_changes(std::span<const ChangeKind> kinds, int num_views,
                                          double times, int num_worlds) {
  std::map<ChangeKind, Found> all;
  for (int i = 0; i < num_worlds; ++i) {
    const auto seed = static_cast<std::uint64_t>(7000 + i);
    Random random(seed);
    const UncertainCamera known = calibrated(opencv5_lens(), random);
    const Dataset world = make_world(opencv5_lens(), seed, pictures(num_views));
    const CameraCheck still = check_camera(world, known);
    for (const ChangeKind kind : kinds) {
      const Lens lens = changed_lens(still, kind, times * (i % 2 == 0 ? 1 : -1));
      const CameraCheck now = check_camera(taken_by(lens, world), known);
      Found& found = all[kind];
      ++found.changes;
      found.found += now.verdict == CheckVerdict::changed;
      found.right_kind += now.change && now.change->kind == kind;
    }
  }
  return all;
}

TEST(CheckCamera, FindsTheChangeThatItStates) {
  const int num_worlds = 400;
  constexpr ChangeKind kKinds[] = {ChangeKind::focal_length, ChangeKind::principal_point,
                                   ChangeKind::focal_and_centre, ChangeKind::lens};
  for (const int num_views : {2, 5, 10})
    for (const auto& [kind, found] : found_changes(kKinds, num_views, 1, num_worlds)) {
      std::printf("%d views, %s: %d found, %d of the right kind of %d\n", num_views,
                  std::string(kind_name(kind)).c_str(), found.found, found.right_kind,
                  found.changes);
      // 98 of 100, less two standard deviations of the count.
      EXPECT_GE(found.found, 0.966 * num_worlds) << num_views << kind_name(kind);
      if (num_views < 5) continue;  // two views do not tell a principal point from a focal length
      if (kind != ChangeKind::focal_length && kind != ChangeKind::principal_point) continue;
      EXPECT_GE(found.right_kind, 0.9 * num_worlds) << num_views << kind_name(kind);
    }
}

TEST(CheckCamera, SaysHowMuchChanged) {
  Random random(3);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  const CameraCheck check = check_camera(make_world(with(0.02, 0), 5, pictures(6)), known);
  ASSERT_EQ(check.verdict, CheckVerdict::changed);
  ASSERT_TRUE(check.change);
  EXPECT_EQ(check.change->kind, ChangeKind::focal_length);
  ASSERT_EQ(check.change->parameters.size(), 2u);
  for (const ParameterChange& p : check.change->parameters) {
    EXPECT_NEAR(p.change, 18, 5 * p.sigma) << p.name;
    EXPECT_LT(p.sigma, 2);
  }
  EXPECT_GT(check.change->max_px, 5);
  const CameraCheck lens = check_camera(make_world(with(0, 0, 0.03), 5, pictures(6)), known);
  ASSERT_TRUE(lens.change);
  EXPECT_EQ(lens.change->kind, ChangeKind::lens);
}

// Larger noise than any file says is no change, and neither is a part of wrong corners; a lens
// that changed by much does not make its own corners outliers.
TEST(CheckCamera, TakesTheNoiseFromThePictures) {
  Random random(4);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  WorldOptions noisy = pictures(10);
  noisy.sigma_px = 1;
  noisy.outlier_share = 0.03;
  const CameraCheck still = check_camera(make_world(opencv5_lens(), 11, noisy), known);
  EXPECT_NE(still.verdict, CheckVerdict::changed) << still.in_sigmas;
  EXPECT_NEAR(still.cameras[0].sigma_px, 1, 0.05);
  const CameraCheck changed = check_camera(make_world(with(0.2, 60, 0.1), 11, noisy), known);
  EXPECT_EQ(changed.verdict, CheckVerdict::changed);
  EXPECT_NEAR(changed.cameras[0].sigma_px, 1, 0.05);
}

TEST(CheckCamera, CannotTellFromPicturesThatShowLittle) {
  Random random(5);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  WorldOptions frontal = pictures(3);
  frontal.max_tilt_deg = 0.5;
  const CameraCheck flat = check_camera(make_world(opencv5_lens(), 12, frontal), known);
  EXPECT_EQ(flat.verdict, CheckVerdict::cannot_tell) << flat.smallest_px;
  const CameraCheck one = check_camera(make_world(with(0.1, 0), 12, pictures(1)), known);
  EXPECT_EQ(one.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(one.findings).contains("few_views"));
  Dataset repeated = make_world(with(0.1, 0), 12, pictures(1));
  repeated.views.push_back(repeated.views.front());
  const CameraCheck twice = check_camera(repeated, known);
  EXPECT_EQ(twice.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(twice.findings).contains("view_repeated"));
  const CameraCheck none = check_camera(make_world(opencv5_lens(), 12, pictures(0)), known);
  EXPECT_EQ(none.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(none.findings).contains("target_unseen"));
}

TEST(CheckCamera, TakesACameraWithoutCovarianceAsExact) {
  const UncertainCamera known{nullptr, {opencv5_lens(), {1280, 800}}, {}};
  CheckOptions options;
  options.limit_px = 5;
  const CameraCheck check =
      check_camera(make_world(opencv5_lens(), 13, pictures(8)), known, options);
  EXPECT_EQ(check.verdict, CheckVerdict::valid) << check.in_sigmas << " " << check.smallest_px;
  EXPECT_TRUE(codes_of(check.findings).contains("camera_exact"));
}

TEST(CheckCamera, RefusesWhatDoesNotFit) {
  const UncertainCamera known{nullptr, {opencv5_lens(), {1280, 720}}, {}};
  EXPECT_THROW(check_camera(make_world(opencv5_lens(), 13, pictures(2)), known), Error);
  const UncertainCamera right{nullptr, {opencv5_lens(), {1280, 800}}, {}};
  for (const double limit : {0.0, -1.0, std::nan("")}) {
    CheckOptions options;
    options.limit_px = limit;
    EXPECT_THROW(check_camera(make_world(opencv5_lens(), 13, pictures(2)), right, options), Error);
  }
}

TEST(CheckCamera, OnePictureBesideItsPose) {
  Random random(6);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  const Dataset still = make_world(opencv5_lens(), 14, pictures(20));
  for (const View& view : still.views)
    EXPECT_FALSE(contradiction_of_camera(view, still.boards, known)) << view.image;
  const Dataset changed = make_world(with(0, 0, 0.1), 14, pictures(20));
  int found = 0;
  for (const View& view : changed.views) {
    const auto finding = contradiction_of_camera(view, changed.boards, known);
    found += finding && finding->code == "camera_changed";
  }
  EXPECT_GE(found, 18);
}

// A rig of known places and lenses, before the board again.
struct CheckedRig {
  KnownRig known;
  RigDataset now;
};

RigDataset instants_of(const RigDataset& rig, std::size_t first, std::size_t end) {
  RigDataset part = rig;
  part.instants.assign(rig.instants.begin() + static_cast<std::ptrdiff_t>(first),
                       rig.instants.begin() + static_cast<std::ptrdiff_t>(end));
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    part.cameras[c].data.views.clear();
    part.cameras[c].times_s.clear();
    for (Instant& instant : part.instants) {
      if (!instant.view[c]) continue;
      part.cameras[c].data.views.push_back(rig.cameras[c].data.views[*instant.view[c]]);
      instant.view[c] = part.cameras[c].data.views.size() - 1;
    }
  }
  return part;
}

// Calibrated by 30 instants; the rest are the pictures of the check.
CheckedRig checked_rig(std::uint64_t seed, int num_cameras, int num_instants,
                       Material material = Material::paper) {
  RigWorldOptions options;
  options.num_cameras = num_cameras;
  options.fisheyes = false;
  options.num_instants = 30 + num_instants;
  Board board = usual_board();
  board.substrate = {material, material};
  const RigDataset all = make_rig_world(seed, options, board);
  return {known_rig(calibrate_rig(instants_of(all, 0, 30))),
          instants_of(all, 30, all.instants.size())};
}

// The corners of one camera by another place of it.
void move_camera(RigDataset& rig, std::size_t c, const Vector6d& step, std::uint64_t seed) {
  Random random(seed);
  const auto points = points_in_world(rig.cameras[c].data.boards);
  const Lens& lens = rig.cameras[c].data.truth->camera.lens;
  for (View& view : rig.cameras[c].data.views) {
    ViewCorrespondences seen = view_correspondences(view, rig.cameras[c].data.boards);
    const PoseEstimate pose = estimate_pose(seen, {lens, {1280, 800}});
    const Pose moved = retract(Pose(), step) * pose.camera_from_target();
    std::erase_if(view.observations, [&](Observation& o) {
      const auto pixel = project(lens, moved * points.at(o.id));
      if (pixel) o.pixel = *pixel + 0.2 * Eigen::Vector2d(random.normal(), random.normal());
      return !pixel || !contains({1280, 800}, *pixel);
    });
  }
}

TEST(CheckRig, TellsWhichCameraMoved) {
  const int num_rigs = 40;
  int alarms = 0, found = 0, right = 0;
  for (int i = 0; i < num_rigs; ++i) {
    CheckedRig rig = checked_rig(static_cast<std::uint64_t>(500 + i), 2 + i % 2, 8);
    const CameraCheck still = check_rig(rig.now, rig.known);
    alarms += still.verdict == CheckVerdict::changed;
    Vector6d step = Vector6d::Zero();
    step << 0.003, -0.002, 0.001, 0.001, 0, 0;
    const std::size_t moved = i % 2 == 0 ? 1 : 2;
    move_camera(rig.now, moved, step, static_cast<std::uint64_t>(i));
    const CameraCheck check = check_rig(rig.now, rig.known);
    found += check.verdict == CheckVerdict::changed;
    right +=
        check.change && check.change->camera == moved && check.change->kind == ChangeKind::place;
  }
  std::printf("rigs: %d false alarms, %d moves found, %d told right of %d\n", alarms, found, right,
              num_rigs);
  EXPECT_LE(alarms, 2);
  EXPECT_EQ(found, num_rigs);
  EXPECT_GE(right, 0.9 * num_rigs);
}

// The paper's scale hides a longer baseline; a board of glass shows it.
TEST(CheckRig, SaysThatThePrintHidesAChangeOfAllLengths) {
  for (const Material material : {Material::paper, Material::glass}) {
    const bool is_glass = material == Material::glass;
    const CheckedRig rig = checked_rig(560, 2, 20, material);
    CheckOptions options;
    options.limit_px = 0.5;
    const CameraCheck check = check_rig(rig.now, rig.known, options);
    EXPECT_EQ(check.verdict, is_glass ? CheckVerdict::valid : CheckVerdict::cannot_tell)
        << check.in_sigmas << " " << check.smallest_px;
    EXPECT_EQ(codes_of(check.findings).contains("scale_untested"), !is_glass);
    for (const DetectableChange& change : check.detectable) {
      if (change.kind != ChangeKind::place) {
        EXPECT_EQ(change.without_scale_px, change.max_px) << kind_name(change.kind);
      } else if (!is_glass) {
        EXPECT_LT(change.without_scale_px, 0.1 * change.max_px);
      }
    }
  }
}

// Pictures of other instants: no rig explains them, and the free one is no measure.
TEST(CheckRig, RefusesPicturesOfOtherInstants) {
  CheckedRig rig = checked_rig(540, 2, 8);
  std::vector<View>& views = rig.now.cameras[1].data.views;
  for (std::size_t v = 1; v < views.size(); ++v)
    std::swap(views[v - 1].observations, views[v].observations);
  const CameraCheck check = check_rig(rig.now, rig.known);
  EXPECT_EQ(check.verdict, CheckVerdict::cannot_tell);
  EXPECT_FALSE(check.change);
  EXPECT_TRUE(std::ranges::any_of(check.findings,
                                  [](const Finding& f) { return f.code == "pair_contradicts"; }));
}

}  // namespace

// A camera without a covariance before pictures of another one, and one of these alone.
std::vector<Case> cases_of_checks() {
  const Dataset seen = make_world(opencv5_lens(), 5, pictures(3));
  const UncertainCamera known{nullptr, {pinhole(900, 900, 639.5, 399.5), seen.image_size}, {}};
  const auto of_view = contradiction_of_camera(seen.views[0], seen.boards, known);
  return {{"camera_exact", {Status::ok, codes_of(check_camera(seen, known).findings)}},
          {"camera_changed", {Status::ok, codes_of({of_view.value()})}}};
}

}  // namespace tagcal
