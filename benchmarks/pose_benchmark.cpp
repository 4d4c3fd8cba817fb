// Pose of one view, with and without focal length, against OpenCV: the same views, double
// precision, one core; methods take turns round by round, and each round gives one ratio.
//
//   pose_benchmark [rounds] [views]

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <opencv2/core.hpp>

#include "tagcal/study/pose_tasks.hpp"

namespace {

using namespace tagcal;

// Of the processor's time, which other programs do not take part in.
double microseconds(const std::vector<PreparedPose>& tasks, int repeats) {
  const std::clock_t begin = std::clock();
  for (int i = 0; i < repeats; ++i)
    for (const PreparedPose& task : tasks) task.solve();
  return 1e6 / CLOCKS_PER_SEC * static_cast<double>(std::clock() - begin) /
         static_cast<double>(repeats) / static_cast<double>(tasks.size());
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

struct Contest {
  std::string title;
  PoseJob job;
  std::vector<PoseTask> tasks;
  std::string reference;  // the peer that the mark is a ratio to
  double mark = 0;
  std::optional<PoseMethod> extra;  // the reference, where it belongs to another job
};

// The share of right answers: a rotation within 5 degrees (of both poses, the better one), a focal
// length within 20 %.
double success(const std::vector<PreparedPose>& prepared, const std::vector<PoseTask>& tasks,
               bool with_focal) {
  int right = 0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const PoseAnswer answer = prepared[i].answer();
    if (!answer.success) continue;
    double angle = angle_between_rad(answer.camera_from_target, tasks[i].camera_from_target);
    for (const PoseAnswer::Alternative& other : answer.alternatives)
      angle =
          std::min(angle, angle_between_rad(other.camera_from_target, tasks[i].camera_from_target));
    const bool focal_right = !with_focal || std::abs(answer.focal_px / 900 - 1) < 0.2;
    right += angle < 5 * kDegree && focal_right;
  }
  return 100.0 * right / static_cast<double>(tasks.size());
}

// Of one method, round by round.
struct Times {
  PoseMethod method;
  std::vector<PreparedPose> prepared;
  int repeats = 1;
  std::vector<double> us;
};

std::vector<Times> timed(const Contest& contest, int rounds) {
  std::vector<PoseMethod> methods = pose_methods(contest.job);
  if (contest.extra) methods.push_back(*contest.extra);
  std::vector<Times> all;
  for (const PoseMethod& method : methods) {
    Times times{method, {}, 1, {}};
    for (const PoseTask& task : contest.tasks) times.prepared.push_back(method.prepare(task));
    const double once = microseconds(times.prepared, 1) * static_cast<double>(contest.tasks.size());
    times.repeats = 1 + static_cast<int>(2000 / std::max(once, 1.0));
    all.push_back(std::move(times));
  }
  for (int i = 0; i < rounds; ++i)
    for (Times& times : all) times.us.push_back(microseconds(times.prepared, times.repeats));
  return all;
}

void race(const Contest& contest, int rounds) {
  const std::vector<Times> all = timed(contest, rounds);
  const auto reference = std::find_if(all.begin(), all.end(), [&](const Times& times) {
    return times.method.name == contest.reference;
  });
  const bool with_focal =
      contest.job == PoseJob::plane_focal || contest.job == PoseJob::four_space_focal;
  std::printf("\n%s (ratios to %s", contest.title.c_str(), contest.reference.c_str());
  if (contest.mark > 0) std::printf("; mark %.3g", contest.mark);
  std::printf(")\n");
  for (const Times& times : all) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < times.us.size(); ++i)
      ratios.push_back(reference->us[i] / times.us[i]);
    std::printf("  %-32s %9.2f us  ratio %7.2f (%.2f to %.2f)", times.method.name.c_str(),
                quantile(times.us, 0.5), quantile(ratios, 0.5), quantile(ratios, 0.1),
                quantile(ratios, 0.9));
    // The reference of another job solves something else.
    if (!contest.extra || times.method.name != contest.extra->name)
      std::printf("  right %5.1f %%", success(times.prepared, contest.tasks, with_focal));
    std::printf("\n");
  }
  std::fflush(stdout);
}

std::vector<PoseTask> draw(const std::vector<Eigen::Vector3d>& points, const ViewRange& range,
                           int views, const std::vector<int>& groups = {}) {
  Random random(7);
  std::vector<PoseTask> tasks;
  for (int i = 0; i < views; ++i) {
    tasks.push_back(draw_task(points, range, random));
    tasks.back().groups = groups;
  }
  return tasks;
}

std::vector<Contest> contests(int views) {
  Random random(3);
  const ViewRange usual;
  ViewRange tilted = usual, wrong = usual;
  tilted.min_tilt_deg = 25;  // where four corners of a board show the focal length
  wrong.wrong = 0.5;
  const auto four = space_points(4, 0.6, random), thirty = space_points(30, 0.6, random);
  const auto square = square_points(0.6);
  const std::string ippe_square = "OpenCV IPPE_SQUARE";
  const std::vector<PoseMethod> of_tags = pose_methods(PoseJob::tag);
  const PoseMethod reference = *std::ranges::find(of_tags, ippe_square, &PoseMethod::name);
  return {{"one tag of 88 mm",
           PoseJob::tag,
           draw(square_points(0.088), usual, views),
           ippe_square,
           4.5,
           {}},
          {"144 corners of a board",
           PoseJob::plane,
           draw(tag_grid_points(6), usual, views),
           "OpenCV IPPE",
           4,
           {}},
          {"30 points in space", PoseJob::space, draw(thirty, usual, views), "OpenCV SQPNP", 0, {}},
          {"pose and focal length, 4 points in a plane", PoseJob::plane_focal,
           draw(square, tilted, views), ippe_square, 8, reference},
          {"pose and focal length, 4 points in space", PoseJob::four_space_focal,
           draw(four, usual, views), ippe_square, 4, reference},
          {"144 corners, half of them wrong",
           PoseJob::outliers,
           draw(tag_grid_points(6), wrong, views / 4 + 1, tag_grid_groups(6)),
           "OpenCV solvePnPRansac",
           10,
           {}}};
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 21;
  const int views = argc > 2 ? std::atoi(argv[2]) : 200;
  if (rounds <= 0 || views <= 0) {
    std::fprintf(stderr, "usage: pose_benchmark [rounds] [views]\n");
    return 2;
  }
  cv::setNumThreads(1);
  std::printf(
      "%d views, %d rounds, OpenCV %s, one thread; us a view, medians; ratios with 10 %% and "
      "90 %% quantiles\nf = 900 px, 1280 x 800, 0.7 to 1.6 m, tilt 0 to 52 degrees, noise "
      "0.5 px; ours with covariance and status\n",
      views, rounds, CV_VERSION);
  for (const Contest& contest : contests(views))
    race(contest, contest.job == PoseJob::outliers ? std::max(1, rounds / 4) : rounds);
  return 0;
}
