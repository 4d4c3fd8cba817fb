#include "tagcal/viewing/frames.hpp"

#include <gtest/gtest.h>

#include "expect.hpp"
#include "poses.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

// Frames parallel to W: C1 with its origin at (4, 2) in W, C2 at (0, 2) in C1.
TEST(Frames, TheChainOfTwoParallelFramesBothWays) {
  const Frames<Pose> frames(
      "W", {{"C2", "C1", translation({0, 2, 0})}, {"C1", "W", translation({4, 2, 0})}});
  const Vector3d b_in_c1(1, 1, 0), c_in_c2(1, 1, 0);
  EXPECT_EQ(frames.a_from_b("W", "C1") * b_in_c1, Vector3d(5, 3, 0));
  EXPECT_EQ(frames.a_from_b("C1", "C2") * c_in_c2, Vector3d(1, 3, 0));
  EXPECT_EQ(frames.a_from_b("W", "C2") * c_in_c2, Vector3d(5, 5, 0));
  EXPECT_EQ(frames.a_from_b("C1", "W") * Vector3d(5, 3, 0), b_in_c1);
  EXPECT_EQ(frames.a_from_b("C2", "C1") * Vector3d(1, 3, 0), c_in_c2);
  EXPECT_EQ(frames.a_from_b("C2", "W") * Vector3d(5, 5, 0), c_in_c2);
}

TEST(Frames, AnyTwoOfARandomTreeAgreeWithTheWayThroughTheRoot) {
  Random random(1);
  Frames<Pose> frames("0");
  std::vector<Pose> root_from_frame{Pose()};
  for (std::size_t i = 1; i < 12; ++i) {
    const std::size_t parent = random.index(i);
    const Pose parent_from_frame = random_pose(random);
    frames.add({std::to_string(i), std::to_string(parent), parent_from_frame});
    root_from_frame.push_back(root_from_frame[parent] * parent_from_frame);
  }
  for (std::size_t a = 0; a < 12; ++a) {
    for (std::size_t b = 0; b < 12; ++b) {
      const Pose direct = frames.a_from_b(std::to_string(a), std::to_string(b));
      const Pose through_root = root_from_frame[a].inverse() * root_from_frame[b];
      EXPECT_LT(angle_between_rad(direct, through_root), 1e-14);
      EXPECT_LT(distance_between_m(direct, through_root), 1e-13);
      const Pose back = frames.a_from_b(std::to_string(b), std::to_string(a)) * direct;
      EXPECT_LT((back.matrix() - Matrix4d::Identity()).norm(), 1e-13);
    }
  }
}

TEST(Frames, TwoCupsOnATableFarAwayKnowEachOtherExactly) {
  const Frames<Pose> frames("world", {{"table", "world", translation({1e12, 1e12, 0})},
                                      {"cup", "table", translation({0.3, 0, 0})},
                                      {"pot", "table", translation({0.1, 0, 0})}});
  EXPECT_EQ(frames.a_from_b("pot", "cup").translation(), Vector3d(0.3 - 0.1, 0, 0));
}

TEST(Frames, AWheelTurnsAndWhatIsOnItsSpokeGoesRound) {
  Frames<Pose> frames("road", {{"wheel", "road", translation({0, 0, 1})},
                               {"bead", "wheel", translation({0.5, 0, 0})}});
  frames.move("wheel", translation({0, 0, 1}) * rotation_about_y(kPi / 2));
  EXPECT_LT((frames.a_from_b("road", "bead").translation() - Vector3d(0, 0, 0.5)).norm(), 1e-15);
}

TEST(Frames, AFrameMovesToAnotherParentWithAllThatHangsOnIt) {
  Frames<Pose> frames("room", {{"table", "room", translation({1, 0, 0})},
                               {"hand", "room", translation({0, 5, 0})},
                               {"cup", "table", translation({0, 0, 1})},
                               {"tea", "cup", translation({0, 0, 0.1})}});
  frames.move({"cup", "hand", translation({0, 0, 2})});
  EXPECT_EQ(frames.parent("cup"), "hand");
  EXPECT_EQ(frames.a_from_b("room", "tea").translation(), Vector3d(0, 5, 2.1));
  EXPECT_EQ(frames.names(), (std::vector<std::string>{"room", "table", "hand", "cup", "tea"}));
  EXPECT_EQ(frames.parent("room"), "");
}

TEST(Frames, AffineOnesStretchAndAShadowHasAWayOutButNoneIn) {
  const Frames<Affine> frames("world", {{"model", "world", scaling({1, 2, 1})},
                                        {"part", "model", affine(rotation_about_z(0.3))},
                                        {"shadow", "world", scaling({1, 1, 0})}});
  const Affine expected = scaling({1, 2, 1}) * rotation_about_z(0.3);
  EXPECT_LT((frames.a_from_b("world", "part").matrix() - expected.matrix()).norm(), 1e-15);
  EXPECT_TRUE((frames.a_from_b("part", "world") * expected).matrix().isIdentity(1e-15));
  EXPECT_EQ(frames.a_from_b("world", "shadow") * Vector3d(1, 2, 3), Vector3d(1, 2, 0));
  EXPECT_ERROR(frames.a_from_b("shadow", "part"),
               "frames: 'shadow' cannot be reached from outside: its transform has no inverse");
}

TEST(Frames, CyclesUnknownAndTakenNamesAreErrorsThatSayWhich) {
  using List = std::vector<Frame<Pose>>;
  const auto made = [](const List& list) {
    return error_of([&] { const Frames<Pose> frames("W", list); });
  };
  EXPECT_EQ(made({{"a", "b", {}}, {"b", "c", {}}, {"c", "a", {}}}),
            "frames: 'a' hangs on itself: a on b on c on a");
  EXPECT_EQ(made({{"d", "a", {}}, {"a", "a", {}}}), "frames: 'a' hangs on itself: a on a");
  EXPECT_EQ(made({{"a", "x", {}}}), "frames: 'x' is no frame");
  EXPECT_EQ(made({{"a", "W", {}}, {"a", "W", {}}}), "frames: 'a' is there twice");
  EXPECT_EQ(made({{"W", "W", {}}}), "frames: 'W' is there twice");
  EXPECT_EQ(made({{"", "W", {}}}), "frames: a frame must have a name");
  EXPECT_EQ(made({{"a", "", {}}}), "frames: '' is no frame");
  EXPECT_EQ(made({{"a", "W", {Eigen::Quaterniond(1, 0, 0, 0), Vector3d(0, kNan, 0)}}}),
            "frames: 'a' has a transform that is not finite");
}

TEST(Frames, AnErrorLeavesTheHierarchyAsItWas) {
  Frames<Pose> frames("W", {{"a", "W", translation({1, 0, 0})}, {"b", "a", {}}, {"c", "b", {}}});
  EXPECT_ERROR(frames.move({"a", "c", {}}), "frames: 'a' hangs on itself: a on c on b on a");
  EXPECT_ERROR(frames.move({"W", "c", {}}), "frames: 'W' is the root and hangs on no other frame");
  EXPECT_THROW(frames.move("W", {}), Error);
  EXPECT_THROW(frames.move("a", {Eigen::Quaterniond(1, 0, 0, 0), Vector3d(0, kNan, 0)}), Error);
  EXPECT_THROW(frames.add({"b", "W", {}}), Error);
  EXPECT_THROW(frames.add({"d", "e", {}}), Error);
  EXPECT_THROW(frames.a_from_b("a", "d"), Error);
  EXPECT_EQ(frames.a_from_b("W", "c").translation(), Vector3d(1, 0, 0));
  EXPECT_EQ(frames.names().size(), 4U);
  frames.add({"d", "c", translation({1, 0, 0})});
  EXPECT_EQ(frames.a_from_b("W", "d").translation(), Vector3d(2, 0, 0));
}

TEST(MatrixStack, KeepsTheInverseBesideTheMatrixAndGoesBackByPop) {
  Random random(2);
  MatrixStack stack;
  stack.multiply(random_pose(random));
  const Matrix4d before = stack.matrix().matrix(), inverse_before = stack.inverse().matrix();
  stack.push();
  EXPECT_EQ(stack.matrix().matrix(), before);
  const Affine stretch = scaling({1, 2, 0.5});
  const Pose turn = random_pose(random);
  stack.multiply(stretch);
  stack.multiply(turn);
  EXPECT_LT((stack.matrix().matrix() - before * (stretch * turn).matrix()).norm(), 1e-14);
  EXPECT_TRUE((stack.matrix() * stack.inverse()).matrix().isIdentity(1e-14));
  stack.pop();
  EXPECT_EQ(stack.matrix().matrix(), before);
  EXPECT_EQ(stack.inverse().matrix(), inverse_before);
}

// The eight calls that place an aircraft in a lecture's OpenGL program turn phi the other way.
TEST(MatrixStack, PlacesAnAircraftByEightCalls) {
  const double phi = 0.4, theta = 0.7, yaw = 0.3, pitch = -0.2, roll = 0.5;
  MatrixStack stack;
  for (const Pose& call : {rotation_about_z(-phi), rotation_about_y(theta), translation({0, 0, 2}),
                           rotation_about_y(-theta), rotation_about_z(phi), rotation_about_z(yaw),
                           rotation_about_x(pitch), rotation_about_y(roll)})
    stack.multiply(call);
  const Pose placed = world_from_aircraft({{2, theta, -phi}, yaw, pitch, roll});
  EXPECT_LT((stack.matrix().matrix() - placed.matrix()).norm(), 4e-15);
}

TEST(MatrixStack, PopOfAnEmptyOneAndASingularMatrixAreErrors) {
  MatrixStack stack;
  EXPECT_ERROR(stack.pop(), "matrix stack: pop of an empty stack");
  EXPECT_THROW(stack.multiply(scaling({1, 0, 1})), Error);
  EXPECT_THROW(stack.multiply(Pose({1, 0, 0, 0}, Vector3d(kNan, 0, 0))), Error);
  EXPECT_TRUE(stack.matrix().matrix().isIdentity(0));
}

TEST(FrameOfThreePoints, HasItsOriginXAxisAndNormalWhereTheySay) {
  const Pose known = world_from_three_points({1, 1, 1}, {1, 1, 2}, {4, 1, 1});
  EXPECT_LT((known.matrix() - translation({1, 1, 1}).matrix()).norm(), 1e-15);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3d a = random_pose(random).translation(), b = random_pose(random).translation(),
                   c = random_pose(random).translation();
    const Pose world_from_frame = world_from_three_points(a, b, c);
    const Pose frame_from_world = world_from_frame.inverse();
    EXPECT_LT((frame_from_world * a).norm(), 1e-14);
    EXPECT_LT((frame_from_world * c - Vector3d((c - a).norm(), 0, 0)).norm(), 1e-14);
    EXPECT_NEAR((frame_from_world * b).y(), 0, 1e-14);
    EXPECT_GT((frame_from_world * b).z(), 0);
    const Vector3d normal = (b - a).cross(c - a).normalized();
    EXPECT_LT((world_from_frame.rotation() * Vector3d::UnitY() - normal).norm(), 1e-13);
  }
}

TEST(FrameOfThreePoints, PointsOnALineAreAnError) {
  EXPECT_THROW(world_from_three_points({0, 0, 0}, {1, 1, 1}, {3, 3, 3}), Error);
  EXPECT_THROW(world_from_three_points({0, 0, 0}, {1, 1, 1}, {0, 0, 0}), Error);
  EXPECT_THROW(world_from_three_points({0, 0, 0}, {kNan, 1, 1}, {0, 0, 1}), Error);
  EXPECT_NO_THROW(world_from_three_points({0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}));
}

}  // namespace
}  // namespace tagcal
