#include "tagcal/study/pose_methods.hpp"

#include <array>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "tagcal/estimate/minimal.hpp"
#include "tagcal/estimate/n_point.hpp"
#include "tagcal/estimate/planar.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// --- ours ---

PreparedPose prepare_estimate_pose(const PoseTask& task) {
  struct State {
    PoseTask task;
    PoseEstimate estimate;
  };
  auto state = std::make_shared<State>(State{task, {}});
  return {[state] {
            PoseOptions options;
            options.sigma_px = state->task.sigma_px;
            options.groups = state->task.groups;
            state->estimate =
                estimate_pose(state->task.correspondences, state->task.camera, options);
          },
          [state] {
            const PoseEstimate& e = state->estimate;
            PoseAnswer answer;
            answer.status = e.status;
            answer.success = is_answer(e.status);
            if (!answer.success) return answer;
            answer.camera_from_target = e.camera_from_target();
            answer.covariance = e.hypotheses.front().covariance;
            if (e.hypotheses.size() > 1) answer.alternative = e.hypotheses[1].camera_from_target;
            return answer;
          }};
}

PreparedPose prepare_estimate_pose_and_focal(const PoseTask& task) {
  struct State {
    PoseTask task;
    PoseAndFocalEstimate estimate;
  };
  auto state = std::make_shared<State>(State{task, {}});
  return {[state] {
            PoseAndFocalOptions options;
            options.sigma_px = state->task.sigma_px;
            options.groups = state->task.groups;
            state->estimate = estimate_pose_and_focal(state->task.correspondences,
                                                      state->task.camera.image_size, options);
          },
          [state] {
            const PoseAndFocalEstimate& e = state->estimate;
            PoseAnswer answer;
            answer.status = e.status;
            answer.success = is_answer(e.status);
            if (!answer.success) return answer;
            answer.camera_from_target = e.camera_from_target();
            answer.focal_px = e.focal_px;
            answer.covariance_with_focal = e.covariance;
            if (e.hypotheses.size() > 1) answer.alternative = e.hypotheses[1].camera_from_target;
            return answer;
          }};
}

// The arrays that the solvers take.
struct SolverInput {
  explicit SolverInput(const PoseTask& task) {
    const auto p = parameters(task.camera.lens);
    for (const Correspondence& c : task.correspondences) {
      points.push_back(c.point);
      plane.push_back(c.point.head<2>());
      from_centre.emplace_back(c.pixel.x() - p[2], c.pixel.y() - p[3]);
      rays.emplace_back(from_centre.back().x() / p[0], from_centre.back().y() / p[1], 1);
    }
  }

  std::vector<Vector3d> points, rays;
  std::vector<Vector2d> plane, from_centre;
};

PoseAnswer answer_of(const std::optional<Pose>& pose, double focal_px = 0) {
  PoseAnswer answer;
  answer.success = pose.has_value();
  if (pose) answer.camera_from_target = *pose;
  answer.focal_px = focal_px;
  return answer;
}

PreparedPose prepare_ippe(const PoseTask& task) {
  struct State {
    SolverInput input;
    Solutions<Pose, 2> poses;
  };
  auto state = std::make_shared<State>(State{SolverInput(task), {}});
  return {[state] {
            state->poses.clear();
            if (const auto h = homography(state->input.plane, state->input.rays))
              state->poses = ippe(*h);
          },
          [state] {
            return answer_of(state->poses.empty() ? std::nullopt
                                                  : std::optional<Pose>(state->poses.front()));
          }};
}

PreparedPose prepare_pnp(const PoseTask& task) {
  struct State {
    SolverInput input;
    Solutions<Pose, 4> poses;
  };
  auto state = std::make_shared<State>(State{SolverInput(task), {}});
  return {[state] { state->poses = pnp(state->input.points, state->input.rays); },
          [state] {
            return answer_of(state->poses.empty() ? std::nullopt
                                                  : std::optional<Pose>(state->poses.front()));
          }};
}

PreparedPose prepare_plane_pose_and_focal(const PoseTask& task) {
  struct State {
    SolverInput input;
    std::optional<PoseAndFocal> found;
  };
  auto state = std::make_shared<State>(State{SolverInput(task), {}});
  return {[state] {
            state->found = plane_pose_and_focal(state->input.plane, state->input.from_centre);
          },
          [state] {
            if (!state->found) return PoseAnswer{};
            return answer_of(state->found->camera_from_target, state->found->focal_px);
          }};
}

PreparedPose prepare_p4pf(const PoseTask& task) {
  struct State {
    SolverInput input;
    Solutions<PoseAndFocal, 6> found;
    Pose truth;
  };
  auto state = std::make_shared<State>(State{SolverInput(task), {}, task.camera_from_target});
  return {[state] {
            state->found = p4pf(std::span<const Vector3d, 4>(state->input.points.data(), 4),
                                std::span<const Vector2d, 4>(state->input.from_centre.data(), 4));
          },
          [state] {
            PoseAnswer best;  // of a minimal solver, the solution nearest to the truth counts
            for (const PoseAndFocal& s : state->found)
              if (!best.success || angle_between_rad(s.camera_from_target, state->truth) <
                                       angle_between_rad(best.camera_from_target, state->truth))
                best = answer_of(s.camera_from_target, s.focal_px);
            return best;
          }};
}

// --- OpenCV ---

struct OpenCvInput {
  explicit OpenCvInput(const PoseTask& task) {
    const auto p = parameters(task.camera.lens);
    k = cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    for (const Correspondence& c : task.correspondences) {
      points.emplace_back(c.point.x(), c.point.y(), c.point.z());
      pixels.emplace_back(c.pixel.x(), c.pixel.y());
    }
  }

  cv::Matx33d k;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Mat rotation, translation, inliers;
  std::vector<cv::Mat> rotations, translations;
  bool success = false;

  PoseAnswer answer() const {
    if (!success || !cv::checkRange(rotation) || !cv::checkRange(translation)) return {};
    const auto vector = [](const cv::Mat& m) {
      return Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
    };
    return answer_of(Pose(exp_rotation(vector(rotation)), vector(translation)));
  }
};

// A method that throws has no answer.
template <typename Solve>
PreparedPose prepared(const PoseTask& task, Solve solve) {
  auto input = std::make_shared<OpenCvInput>(task);
  return {[input, solve] {
            try {
              input->success = solve(*input);
            } catch (const cv::Exception&) {
              input->success = false;
            }
          },
          [input] { return input->answer(); }};
}

PoseMethod solve_pnp(const std::string& name, cv::SolvePnPMethod flag) {
  return {"OpenCV " + name, [flag](const PoseTask& task) {
            return prepared(task, [flag](OpenCvInput& in) {
              return cv::solvePnP(in.points, in.pixels, in.k, cv::noArray(), in.rotation,
                                  in.translation, false, flag);
            });
          }};
}

// Both solutions of a plane, as ours returns them; the better one is the first.
PoseMethod solve_pnp_both(const std::string& name, cv::SolvePnPMethod flag) {
  return {"OpenCV " + name, [flag](const PoseTask& task) {
            return prepared(task, [flag](OpenCvInput& in) {
              if (cv::solvePnPGeneric(in.points, in.pixels, in.k, cv::noArray(), in.rotations,
                                      in.translations, false, flag) < 1)
                return false;
              in.rotation = in.rotations.front();
              in.translation = in.translations.front();
              return true;
            });
          }};
}

// The tolerance that suits the noise, enough iterations for half of the points being wrong several
// times over.
PoseMethod solve_pnp_ransac(const std::string& name, cv::SolvePnPMethod flag) {
  return {"OpenCV " + name, [flag](const PoseTask& task) {
            const float tolerance = static_cast<float>(4 * task.sigma_px);
            return prepared(task, [flag, tolerance](OpenCvInput& in) {
              return cv::solvePnPRansac(in.points, in.pixels, in.k, cv::noArray(), in.rotation,
                                        in.translation, false, 1000, tolerance, 0.9999, in.inliers,
                                        flag);
            });
          }};
}

PoseMethod solve_pnp_usac(const std::string& name, int method) {
  return {"OpenCV " + name, [method](const PoseTask& task) {
            cv::UsacParams params;
            params.threshold = 4 * task.sigma_px;
            params.maxIterations = 1000;
            params.confidence = 0.9999;
            params.sampler = cv::SAMPLING_UNIFORM;
            params.score =
                method == cv::USAC_MAGSAC ? cv::SCORE_METHOD_MAGSAC : cv::SCORE_METHOD_MSAC;
            params.loMethod = cv::LOCAL_OPTIM_INNER_LO;
            return prepared(task, [params](OpenCvInput& in) {
              cv::Mat k(in.k);
              return cv::solvePnPRansac(in.points, in.pixels, k, cv::noArray(), in.rotation,
                                        in.translation, in.inliers, params);
            });
          }};
}

// The only way of OpenCV to a focal length from one view; a plane only.
PreparedPose prepare_calibrate_camera(const PoseTask& task) {
  struct State {
    explicit State(const PoseTask& task)
        : input(task), size(task.camera.image_size.width, task.camera.image_size.height) {
      for (const Correspondence& c : task.correspondences) {
        points.emplace_back(static_cast<float>(c.point.x()), static_cast<float>(c.point.y()),
                            static_cast<float>(c.point.z()));
        pixels.emplace_back(static_cast<float>(c.pixel.x()), static_cast<float>(c.pixel.y()));
      }
    }
    OpenCvInput input;
    cv::Size size;
    std::vector<cv::Point3f> points;
    std::vector<cv::Point2f> pixels;
    cv::Mat k, distortion;
  };
  auto state = std::make_shared<State>(task);
  return {[state] {
            const int flags = cv::CALIB_FIX_PRINCIPAL_POINT | cv::CALIB_FIX_ASPECT_RATIO |
                              cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 |
                              cv::CALIB_FIX_K3;
            state->k = cv::Mat::eye(3, 3, CV_64F);  // the aspect ratio is 1
            state->distortion = cv::Mat();
            try {
              cv::calibrateCamera(std::vector{state->points}, std::vector{state->pixels},
                                  state->size, state->k, state->distortion, state->input.rotations,
                                  state->input.translations, flags);
              state->input.rotation = state->input.rotations.front();
              state->input.translation = state->input.translations.front();
              state->input.success = true;
            } catch (const cv::Exception&) {
              state->input.success = false;
            }
          },
          [state] {
            PoseAnswer answer = state->input.answer();
            if (answer.success) answer.focal_px = state->k.at<double>(0, 0);
            return answer;
          }};
}

}  // namespace

std::vector<PoseMethod> pose_methods(PoseJob job) {
  const PoseMethod ours = {"tagcal estimate_pose", prepare_estimate_pose};
  const PoseMethod ours_focal = {"tagcal estimate_pose_and_focal", prepare_estimate_pose_and_focal};
  const PoseMethod our_pnp = {"tagcal pnp", prepare_pnp};
  const PoseMethod our_ippe = {"tagcal homography + ippe", prepare_ippe};
  const PoseMethod iterative = solve_pnp("ITERATIVE", cv::SOLVEPNP_ITERATIVE);
  const PoseMethod sqpnp = solve_pnp("SQPNP", cv::SOLVEPNP_SQPNP);
  const PoseMethod epnp = solve_pnp("EPNP", cv::SOLVEPNP_EPNP);
  const PoseMethod ippe = solve_pnp_both("IPPE", cv::SOLVEPNP_IPPE);
  const PoseMethod ippe_square = solve_pnp_both("IPPE_SQUARE", cv::SOLVEPNP_IPPE_SQUARE);
  switch (job) {
    case PoseJob::tag:
      return {ours,      our_ippe, our_pnp, ippe_square,
              iterative, sqpnp,    epnp,    solve_pnp("AP3P", cv::SOLVEPNP_AP3P)};
    case PoseJob::plane:
      return {ours, our_ippe, our_pnp, ippe, iterative, sqpnp, epnp};
    case PoseJob::space:
      return {ours, our_pnp, iterative, sqpnp, epnp};
    case PoseJob::outliers:
      return {ours,
              solve_pnp_ransac("solvePnPRansac", cv::SOLVEPNP_ITERATIVE),
              solve_pnp_ransac("solvePnPRansac AP3P", cv::SOLVEPNP_AP3P),
              solve_pnp_ransac("solvePnPRansac SQPNP", cv::SOLVEPNP_SQPNP),
              solve_pnp_usac("USAC (MSAC, inner LO)", cv::USAC_DEFAULT),
              solve_pnp_usac("USAC MAGSAC", cv::USAC_MAGSAC)};
    case PoseJob::plane_focal:
      return {ours_focal,
              {"tagcal plane_pose_and_focal", prepare_plane_pose_and_focal},
              {"OpenCV calibrateCamera", prepare_calibrate_camera}};
    case PoseJob::space_focal:
      return {ours_focal, {"tagcal p4pf", prepare_p4pf}};
  }
  return {};
}

}  // namespace tagcal
