#include "tagcal/io/robot_poses.hpp"

#include "file_fixture.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal {
namespace {

class RobotPosesFile : public FileTest {
 protected:
  RobotPoses read(const std::string& text, const std::string& columns = "") const {
    return read_robot_poses(write("robot.csv", text), columns);
  }
  std::string error(const std::string& text, const std::string& columns = "") const {
    const fs::path file = write("robot.csv", text);
    std::string message = error_of([&] { read_robot_poses(file, columns); });
    const std::string name = file.string() + ": ";
    return message.starts_with(name) ? message.substr(name.size()) : message;
  }
};

using internal::kDegree;
const Pose kTurned(rotation_about_z(30 * kDegree).rotation(), {0.1, 0.2, 0.3});

void expect_turned(const Pose& pose) { EXPECT_LT(minus(pose, kTurned).norm(), 1e-6); }

TEST_F(RobotPosesFile, HasQuaternionsByTheNamesOfPictures) {
  const RobotPoses poses = read(
      "# from the controller\n"
      "image,x_mm,y_mm,z_mm,qx,qy,qz,qw,tool\n"
      "a.png,100,200,300,0,0,0.2588190451,0.9659258263,3\n"
      "b.png,0,0,0,0,0,0,1,3\n");
  EXPECT_EQ(poses.images, (std::vector<std::string>{"a.png", "b.png"}));
  EXPECT_TRUE(poses.times_s.empty());
  ASSERT_EQ(poses.base_from_hand.size(), 2u);
  expect_turned(poses.base_from_hand[0]);
}

TEST_F(RobotPosesFile, HasEachKindOfRotation) {
  expect_turned(read("x_m,y_m,z_m,rx_deg,ry_deg,rz_deg\n0.1,0.2,0.3,0,0,30\n").base_from_hand[0]);
  expect_turned(
      read("x_m y_m z_m rx_rad ry_rad rz_rad\n0.1 0.2 0.3 0 0 0.5235987756\n").base_from_hand[0]);
  expect_turned(
      read("x_m,y_m,z_m,roll_deg,pitch_deg,yaw_deg\n0.1,0.2,0.3,0,0,30\n").base_from_hand[0]);
  expect_turned(read("m00 m01 m02 m03_mm m10 m11 m12 m13_mm m20 m21 m22 m23_mm\n"
                     "0.8660254 -0.5 0 100 0.5 0.8660254 0 200 0 0 1 300\n")
                    .base_from_hand[0]);
}

TEST_F(RobotPosesFile, HasTumAndRos) {
  const RobotPoses tum = read(
      "# timestamp tx ty tz qx qy qz qw\n"
      "1.5 0.1 0.2 0.3 0 0 0.2588190451 0.9659258263\n"
      "1.6 0.1 0.2 0.3 0 0 0 1\n");
  EXPECT_EQ(tum.times_s, (std::vector<double>{1.5, 1.6}));
  expect_turned(tum.base_from_hand[0]);
  const RobotPoses ros = read(
      "%time,field.header.stamp,field.transform.translation.x,field.transform.translation.y,"
      "field.transform.translation.z,field.transform.rotation.x,field.transform.rotation.y,"
      "field.transform.rotation.z,field.transform.rotation.w\n"
      "7,1500000000,0.1,0.2,0.3,0,0,0.2588190451,0.9659258263\n");
  EXPECT_EQ(ros.times_s, std::vector<double>{1.5});
  expect_turned(ros.base_from_hand[0]);
}

TEST_F(RobotPosesFile, ReadsViSPsFilesInTheOrderOfTheirNumbers) {
  const std::string rest = "]\n  - [0.2]\n  - [0.3]\n  - [0]\n  - [0]\n  - [0.5235987756]\n";
  const std::vector<std::string> numbers = {
      "0",
      "1",
      "02",
      "10",
      "2147483647",
      "2147483648",
      "99999999999999999998",
      "99999999999999999999"};  // beyond those of int and of 64 bits
  for (std::size_t i = 0; i < numbers.size(); ++i)
    write("pose_rPe_" + numbers[i] + ".yaml",
          "rows: 6\ncols: 1\ndata:\n  - [" + std::to_string(i) + rest);
  const RobotPoses poses = read_robot_poses(folder_);
  ASSERT_EQ(poses.base_from_hand.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_EQ(poses.base_from_hand[i].translation().x(), static_cast<double>(i)) << numbers[i];
}

TEST_F(RobotPosesFile, RefusesBadTables) {
  const std::string header = "image,x_m,y_m,z_m,qw,qx,qy,qz\n";
  EXPECT_EQ(error(header + "a,0,0,0,0.9,0,0,0\n"),
            "line 2: the quaternion must have unit length, got 0.9");
  EXPECT_EQ(error(header + "a,0,0,nan,1,0,0,0\n"), "line 2: z_m: must be a finite number, got nan");
  EXPECT_EQ(error(header + "a,0,0,0,1,0,0,0\na,0,0,0,1,0,0,0\n"),
            "line 3: image: a has a pose already");
  EXPECT_EQ(error(header + "a,0,0,0,1,0,0\n"), "line 2: must have 8 fields, got 7");
  EXPECT_EQ(error(header), "has no pose");
  EXPECT_TRUE(error("image,x,y,z,qw,qx,qy,qz\n").starts_with("line 1: column x: has no unit"));
  EXPECT_TRUE(error("image,x_m,y_m,z_m,qw\n").starts_with("line 1: needs one rotation"));
  EXPECT_TRUE(error("1 2 3\n").starts_with("line 1: must name the columns"));
  EXPECT_TRUE(error("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n").starts_with("line 2: the times must"));
  EXPECT_TRUE(
      error("1 2 3 4 5 6 7\n", "x_m y_m z_m a b c d").starts_with("--robot-format: column a"));
  const std::string matrix = "m00 m01 m02 m10 m11 m12 m20 m21 m22 x_m y_m z_m\n";
  EXPECT_TRUE(error(matrix + "1 0 0 0 1 0 0 0 -1 0 0 0\n").starts_with("line 2: the matrix m00"));
  EXPECT_TRUE(error("x_m y_m z_m rx_rad ry_rad rz_rad\n0 0 0 0 0 30\n")
                  .starts_with("line 2: the rotation vector must be at most a full turn"));
}

}  // namespace
}  // namespace tagcal
