#include <gtest/gtest.h>

#include "file_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"

// What a camera's file says of the camera's uncertainty must be one, and of this camera.

namespace tagcal {
namespace {

const std::string kPinhole =
    "image_width: 640\nimage_height: 480\nmodel: pinhole\n"
    "camera_matrix: {rows: 3, cols: 3, data: [900, 0, 320, 0, 901, 240, 0, 0, 1]}\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
    "covariance_names: [fx, fy, cx, cy]\n"
    "covariance: {rows: 4, cols: 4, data: [4, 1, 0, 0,  1, 9, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]}\n"
    "parameter_names: [fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6]\n"
    "sigmas: {rows: 1, cols: 12, data: [2, 3, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]}\n";

class CameraUncertaintyTest : public FileTest {
 protected:
  CalibrationFile read(const std::string& text) const {
    return read_calibration(write("c.yaml", text));
  }
  std::string error(const std::string& text) const {
    const std::string message = error_of([&] { read(text); });
    const std::string name = (folder_ / "c.yaml").string() + ": ";
    return message.starts_with(name) ? message.substr(name.size()) : "names no file: " + message;
  }
  static std::string with(const std::string& covariance) {
    return replaced(kPinhole, "4, 1, 0, 0,  1, 9, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1", covariance);
  }
};

TEST_F(CameraUncertaintyTest, ACovarianceThatIsNoneIsRefused) {
  EXPECT_EQ(read(kPinhole).covariance(0, 1), 1);
  const std::vector<std::pair<std::string, std::string>> table = {
      {"-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1",
       "covariance: must have variances from 0 to 1e+100, got -1"},
      {"1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e300, 0, 0, 0, 0, 1",
       "covariance: must have variances from 0 to 1e+100, got 1e+300"},
      {"1, 5, 0, 0, 5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1",
       "covariance: must be positive semi-definite"},
      {"4, 1, 0, 0, 2, 9, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1",
       "covariance: must be symmetric, got 1 and 2"},
      {"4, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1",
       "covariance: must be positive semi-definite"}};
  for (const auto& [covariance, message] : table) EXPECT_EQ(error(with(covariance)), message);
}

TEST_F(CameraUncertaintyTest, SigmasAreThoseOfTheCovariance) {
  EXPECT_EQ(error(replaced(kPinhole, "[2, 3, 1,", "[1, 3, 1,")),
            "sigmas: must be 2 for fx by the covariance, got 1");
  EXPECT_EQ(error(replaced(kPinhole, "1, 1, 0, 0,", "1, 1, 0.01, 0,")),
            "sigmas: must be 0 for k1 by the covariance, got 0.01");
  EXPECT_EQ(read(replaced(kPinhole, "[2, 3, 1,", "[2.00001, 3, 1,")).sigmas[0], 2.00001);
}

// Units differ: a wrong covariance of coefficients is small beside the variances in pixels.
TEST_F(CameraUncertaintyTest, EachParameterHasItsUnit) {
  const std::string named =
      replaced(replaced(replaced(kPinhole, "model: pinhole", "model: radial2"), "900, 0, 320",
                        "901, 0, 320"),
               "[fx, fy, cx, cy]", "[f, cx, cy, k1, k2]");
  const std::string radial = replaced(named, "[2, 3, 1, 1, 0, 0,", "[1, 1, 1, 1, 1e-4, 1e-4,");
  const auto of = [&](const std::string& k) {
    return replaced(radial,
                    "rows: 4, cols: 4, data: [4, 1, 0, 0,  1, 9, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]",
                    "rows: 5, cols: 5, data: [1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, "
                    "0, 0, 0, " +
                        k + "]");
  };
  EXPECT_EQ(error(of("1e-8, 2e-8, 0, 0, 0, 2e-8, 1e-8")),
            "covariance: must be positive semi-definite");
  EXPECT_EQ(error(of("1e-8, 2e-9, 0, 0, 0, 3e-9, 1e-8")),
            "covariance: must be symmetric, got 2e-09 and 3e-09");
  EXPECT_EQ(read(of("1e-8, 2e-9, 0, 0, 0, 2e-9, 1e-8")).covariance(3, 4), 2e-9);
}

TEST_F(CameraUncertaintyTest, ACovarianceMayBeSingularAndRounded) {
  const auto alone = [](const std::string& covariance) {
    const std::string text = with(covariance);
    return text.substr(0, text.find("parameter_names"));
  };
  // Of parameters that are known, and of two that differ by a constant, in six digits.
  EXPECT_NO_THROW(read(alone("0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0")));
  EXPECT_NO_THROW(read(alone("4, 4, 0, 0, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1")));
  EXPECT_NO_THROW(
      read(alone("0.333333, 0.666667, 0, 0, 0.666667, 1.33333, 0, 0, 0, 0, 1, 0, "
                 "0, 0, 0, 1")));
  EXPECT_NO_THROW(read(alone("4, 1, 0, 0, 1.0000001, 9, 0, 0, 0, 0, -1e-18, 0, 0, 0, 0, 1")));
}

TEST_F(CameraUncertaintyTest, NamesAreThoseOfTheValues) {
  EXPECT_NO_THROW(read(replaced(kPinhole, "covariance_names: [fx, fy, cx, cy]\n", "")));
  for (const std::string names : {"cy, cx, fy, fx", "fx, fy, zz, cy", "fx, fx, cx, cy", "fx, fy"})
    EXPECT_EQ(error(replaced(kPinhole, "[fx, fy, cx, cy]", "[" + names + "]")),
              "covariance_names: must be fx, fy, cx, cy with model pinhole, got " + names);
  const std::string swapped = replaced(kPinhole, "[fx, fy, cx, cy, k1", "[fy, fx, cx, cy, k1");
  EXPECT_EQ(error(swapped).substr(0, 84),
            "parameter_names: must be fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6, got fy, fx,");
}

TEST_F(CameraUncertaintyTest, FixedValuesAreThoseOfTheCamera) {
  const std::string plain = kPinhole.substr(0, kPinhole.find("covariance_names"));
  EXPECT_EQ(read(plain + "fixed: {fx: 900, k1: 0}\n").fixed.at("fx"), 900);
  EXPECT_EQ(error(plain + "fixed: {fx: 1}\n"), "fixed: fx must be 900 as in the camera, got 1");
  EXPECT_EQ(error(plain + "fixed: {k1: 0.5}\n"), "fixed: k1 must be 0 as in the camera, got 0.5");
  EXPECT_EQ(error(plain + "fixed: {fx: -1}\n"), "fixed: fx must be > 0, got -1");
  EXPECT_EQ(error(plain + "fixed: {zz: 1}\n").substr(0, 30), "fixed: must be one of f, fx, f");
  EXPECT_EQ(error(plain + "fixed: [1]\n"), "fixed: must be a map of keys, got a list of 1");
}

}  // namespace
}  // namespace tagcal
