// Boards that are followed from frame to frame: the corners of a search, at less work.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

const Board kGrid = make_board(AprilGrid{5, 4, 0.044, 0.3});

// A camera that moves along the board, which is larger than the picture if `aside` says so.
class Clip {
 public:
  explicit Clip(const Board& board) : boards_{{board, Pose()}} {
    scene_.camera = {Perspective({420, 420, 199.5, 149.5, -0.2, 0.05}), {400, 300}};
    scene_.boards = boards_;
    scene_.sensor = {1, 0.6, 2};
  }

  // The board's middle is `aside_m` from the optical axis.
  Image8 frame(double aside_m, double turn_rad, std::uint64_t seed) const {
    const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Vector3d(0.5, 1, 0).normalized()));
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ()) * tilt * facing;
    const Pose pose(turn, Vector3d(aside_m, 0, 0.45) - turn * Vector3d(0.14, 0.11, 0));
    const ImageF light = render_light(scene_, tag_families(boards_), pose);
    return expose(light, scene_.sensor, seed);
  }
  // About 7 px to the side and half a degree from frame to frame.
  Image8 frame(int i) const { return frame(0.0075 * i - 0.03, 0.01 * i, 10 + i); }

  const std::vector<PlacedBoard>& boards() const { return boards_; }

 private:
  std::vector<PlacedBoard> boards_;
  Scene scene_;
};

// Expects the corners of a search but for what its convergence leaves, a few hundredths of a pixel
// at most, and fewer than one in twenty by more than a standard deviation.
void expect_corners_of_search(const View& found, const View& searched) {
  ASSERT_EQ(found.observations.size(), searched.observations.size()) << found.image;
  std::ptrdiff_t off = 0;
  for (std::size_t i = 0; i < found.observations.size(); ++i) {
    const Observation &a = found.observations[i], &b = searched.observations[i];
    ASSERT_EQ(a.id, b.id);
    const double px = (a.pixel - b.pixel).norm();
    EXPECT_LT(px, 0.03) << "tag " << a.id.tag_id << " corner " << a.id.corner;
    off += px > std::sqrt(b.covariance_px2->trace() / 2);
  }
  EXPECT_LT(20 * off, std::ssize(found.observations));
}

class BoardTrackerOf : public testing::TestWithParam<Board> {};

TEST_P(BoardTrackerOf, FollowsTheBoardToTheCornersOfASearch) {
  const Clip clip(GetParam());
  BoardTracker tracker(clip.boards());
  for (int i = 0; i < 8; ++i) {
    const Image8 picture = clip.frame(i);
    const View found = tracker.next(picture).view;
    EXPECT_EQ(tracker.has_followed(), i > 0) << "frame " << i;
    EXPECT_GT(found.observations.size(), 20U);
    expect_corners_of_search(found, detect(picture, clip.boards()).view);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, BoardTrackerOf,
                         testing::Values(kGrid, make_board(Checkerboard{8, 6, 0.03, 0.03}),
                                         make_board(Charuco{9, 7, 0.03, 0.022, "DICT_5X5_100"})));

TEST(BoardTracker, FindsTagsThatComeAndGoAtTheEdge) {
  const Clip clip(kGrid);
  BoardTracker tracker(clip.boards());
  std::set<int> seen;
  std::size_t least = 20, most = 0;
  for (int i = 0; i < 14; ++i) {
    const Image8 picture = clip.frame(-0.19 + 0.012 * i, 0, 3 + i);
    const View found = tracker.next(picture).view;
    EXPECT_EQ(tracker.has_followed(), i > 0) << "frame " << i;
    expect_corners_of_search(found, detect(picture, clip.boards()).view);
    for (const Observation& corner : found.observations) seen.insert(corner.id.tag_id);
    least = std::min(least, found.observations.size() / 4);
    most = std::max(most, found.observations.size() / 4);
  }
  EXPECT_LT(least + 5, most);
  EXPECT_EQ(seen.size(), 20U);
}

TEST(BoardTracker, SearchesAgainWhereATagIsHidden) {
  const Clip clip(kGrid);
  BoardTracker tracker(clip.boards());
  tracker.next(clip.frame(0));
  Image8 picture = clip.frame(1);
  for (int y = 130; y < 165; ++y)
    for (int x = 180; x < 215; ++x) picture(x, y) = 90;
  const View found = tracker.next(picture).view;
  EXPECT_FALSE(tracker.has_followed());
  EXPECT_LT(found.observations.size(), 80U);
  expect_corners_of_search(found, detect(picture, clip.boards()).view);
  // What is hidden all the time is not lost again.
  Image8 next = clip.frame(2);
  for (int y = 130; y < 165; ++y)
    for (int x = 188; x < 223; ++x) next(x, y) = 90;
  tracker.next(next);
  EXPECT_TRUE(tracker.has_followed());
}

TEST(BoardTracker, SearchesAfterACut) {
  const Clip clip(kGrid);
  BoardTracker tracker(clip.boards());
  tracker.next(clip.frame(0));
  const Image8 empty({400, 300});
  EXPECT_TRUE(tracker.next(empty).view.observations.empty());
  EXPECT_FALSE(tracker.has_followed());
  tracker.next(clip.frame(1));
  EXPECT_FALSE(tracker.has_followed());
  const Image8 far = clip.frame(0.1, 1.5, 1);  // a quarter of a turn
  const View found = tracker.next(far).view;
  EXPECT_FALSE(tracker.has_followed());
  expect_corners_of_search(found, detect(far, clip.boards()).view);
}

// A board of markers that look alike but for their ids, moved by two squares: the squares are where
// others were.
TEST(BoardTracker, ReadsTheMarkersBetweenSquares) {
  const Board board = make_board(Charuco{9, 7, 0.03, 0.022, "DICT_5X5_100"});
  const Clip clip(board);
  BoardTracker tracker(clip.boards());
  for (const double aside_m : {0.0, 0.06, -0.06, 0.0}) {
    const Image8 picture = clip.frame(aside_m, 0, 5);
    expect_corners_of_search(tracker.next(picture).view, detect(picture, clip.boards()).view);
  }
}

std::vector<ImageSource> frames_of(const Clip& clip, int count) {
  std::vector<ImageSource> frames;
  for (int i = 0; i < count; ++i)
    frames.push_back({std::to_string(i), [&clip, i] { return clip.frame(i % 8); }, i > 0});
  return frames;
}

TEST(BoardTracker, FramesOfASequenceDoNotDependOnTheNumberOfThreads) {
  const Clip clip(make_board(AprilGrid{3, 2, 0.044, 0.3}));
  const std::vector<ImageSource> frames = frames_of(clip, 45);
  std::vector<std::vector<DetectedPicture>> results;
  int done = 0;
  for (const int threads : {1, 3}) {
    DetectOptions options;
    options.threads = threads;
    results.push_back(detect_all(frames, clip.boards(), options, [&](int now, int all) {
      EXPECT_EQ(all, 45);
      done = now;
    }));
    EXPECT_EQ(done, 45);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto &a = results[0][i].view.observations, &b = results[1][i].view.observations;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].pixel, b[k].pixel);
      EXPECT_EQ(*a[k].covariance_px2, *b[k].covariance_px2);
    }
  }
}

// A range of frames is found again if one of it is not known: it is the start of the next.
TEST(BoardTracker, EarlierResultsOfASequenceAreThoseOfWholeRanges) {
  const Clip clip(make_board(AprilGrid{3, 2, 0.044, 0.3}));
  const std::vector<ImageSource> frames = frames_of(clip, 22);
  std::map<std::size_t, DetectedPicture> kept;
  std::map<std::size_t, std::size_t> firsts;
  EarlierResults earlier;
  earlier.find = [&](std::size_t i, std::size_t first) -> std::optional<DetectedPicture> {
    firsts[i] = first;
    const auto known = kept.find(i);
    return known == kept.end() ? std::nullopt : std::optional(known->second);
  };
  std::set<std::size_t> found;
  earlier.keep = [&](std::size_t i, const DetectedPicture& picture) {
    kept[i] = picture;
    found.insert(i);
  };
  DetectOptions options;
  options.threads = 1;
  options.earlier = &earlier;
  detect_all(frames, clip.boards(), options);
  EXPECT_EQ(found.size(), 22U);
  EXPECT_EQ(firsts[19], 0U);
  EXPECT_EQ(firsts[21], 20U);
  found.clear();
  kept.erase(21);
  detect_all(frames, clip.boards(), options);
  EXPECT_EQ(found, (std::set<std::size_t>{20, 21}));
}

TEST(BoardTracker, AFrameThatCannotBeReadEndsTheRunOrIsSkipped) {
  const Clip clip(make_board(AprilGrid{3, 2, 0.044, 0.3}));
  std::vector<ImageSource> frames = frames_of(clip, 45);
  frames[5].load = []() -> Image8 { throw Error("frame 5"); };
  DetectOptions options;
  options.threads = 3;
  EXPECT_THROW(detect_all(frames, clip.boards(), options), Error);
  options.skip_unreadable = true;
  const auto found = detect_all(frames, clip.boards(), options);
  EXPECT_EQ(found[5].unreadable, "frame 5");
  EXPECT_EQ(found[6].view.observations.size(), 24U);
}

}  // namespace
}  // namespace tagcal
