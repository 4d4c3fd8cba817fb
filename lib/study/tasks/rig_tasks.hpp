#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "study/method.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/rig.hpp"

// Rigs for studies: perspectives of 1280 x 800 pixels on one body, before a board of 0.66 m.

namespace tagcal::study {

struct RigKind {
  int num_cameras = 2, num_instants = 20;
  double spread = 1;   // of the board's tilts and places; 0: it stays
  double late = 0;     // instants by which the last camera's pictures are later
  double moved_m = 0;  // of the last camera, from two thirds of the instants on
  double common = 1;   // share of the instants at which the last camera sees the board
  // Two cameras back to back, each before a board of its own whose place is unknown, on a body that
  // turns by up to 0.5 rad about x, and by up to `other_turns` rad about y and z.
  bool is_wheel = false;
  bool is_grid = false;  // the board is a regular grid of 12 x 12 points, which mrcal needs
  double other_turns = 0;
};

struct RigTask {
  RigDataset rig;  // with its truth, and that of each camera
  double sigma_px = 0;
  std::vector<Pose> rig_from_world;  // by instant; of the cameras that are in time
};

// Parts of a random rig, for others too: a step of at most `rad` and `m` in each coordinate, a pose plus
// sums of slow waves of its six coordinates about a centre, by the time in instants, and a lens.
Vector6d random_step(Random& random, double rad, double m);
std::function<Pose(double)> steady_motion(const Pose& middle, const Eigen::Vector3d& centre,
                                          Random& random);
Lens draw_rig_lens(Random& random);

RigTask draw_rig(const RigKind& kind, Random& random);

// The information about the places of all cameras but the first, (omega, tau) each, with unknown
// lenses (opencv5), poses of the rig and places of further boards; its inverse is the Cramer-Rao
// bound. Empty if it is singular.
Eigen::MatrixXd rig_information(const RigTask& task);

struct RigAnswer {
  std::vector<Pose> camera_from_first;  // of all cameras; empty: no answer
  Eigen::MatrixXd covariance;           // as of rig_information; empty: the method states none
  bool warned = false;                  // of data that may not be as they should
  std::string said = "no answer";

  // The errors of all cameras but the first (`minus`); none without an answer.
  Eigen::VectorXd error(const RigDataset& rig) const;
};
using RigMethod = Method<RigTask, RigAnswer>;

// `tagcal rig`, and OpenCV's stereoCalibrate after calibrateCamera of each camera, both with lenses
// that are estimated and held. Of more than two cameras OpenCV's pairs of neighbours are chained.
// mrcal, if installed, for rigs before a regular grid.
std::vector<RigMethod> rig_methods(const RigKind& kind = {});

}  // namespace tagcal::study
