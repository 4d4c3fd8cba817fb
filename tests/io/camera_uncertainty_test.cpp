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
    return error_about((folder_ / "c.yaml").string() + ": ", [&] { read(text); });
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

// f+c, whose f is the mean of the claim's fx and fy: (4 + 2 x 1 + 9) / 4 = 3.75.
const std::string kClaim =
    "image_width: 640\nimage_height: 480\nmodel: f+c\n"
    "camera_matrix: {rows: 3, cols: 3, data: [900, 0, 320, 0, 900, 240, 0, 0, 1]}\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
    "covariance: {rows: 3, cols: 3, data: [3.75, 0.5, 0,  0.5, 1, 0,  0, 0, 1]}\n"
    "claim_model: pinhole\n"
    "claim_names: [fx, fy, cx, cy]\n"
    "claim_covariance: {rows: 4, cols: 4, data: [4, 1, 1, 0, 1, 9, 0, 0, 1, 0, 1, 0, 0, 0, 0, "
    "1]}\n";

TEST_F(CameraUncertaintyTest, TheClaimIsTheSourceOfAllUncertainty) {
  const UncertainCamera claim = uncertain_camera(read(kClaim));
  ASSERT_EQ(claim.model, &Model::named("pinhole"));
  EXPECT_EQ(claim.covariance(1, 1), 9);
  EXPECT_EQ(parameters(claim.camera.lens)[0], 900);
  const std::string radial = replaced(kClaim, "claim_model: pinhole", "claim_model: radial1");
  EXPECT_NO_THROW(read(replaced(replaced(radial, "claim_names: [fx, fy, cx, cy]", ""),
                                "[4, 1, 1, 0, 1, 9, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1]",
                                "[3.75, 0.5, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0]")));
}

TEST_F(CameraUncertaintyTest, AConvertedFileKeepsTheClaim) {
  const CameraFile file = read_camera_file(write("c.yaml", kClaim));
  write_camera_file(folder_ / "again.yaml", file, "tagcal");
  const CalibrationFile again = read_calibration(folder_ / "again.yaml");
  EXPECT_EQ(again.claim_model, "pinhole");
  EXPECT_EQ(again.claim_covariance, file.cameras[0].calibration.claim_covariance);
  EXPECT_EQ(again.covariance, file.cameras[0].calibration.covariance);
}

TEST_F(CameraUncertaintyTest, AConvertedFileKeepsTheWarnings) {
  const std::string warnings =
      "warnings: [\"no corners at the left\", \"so it is\"]\nwarning_codes: [coverage, input]\n"
      "warning_severities: [warning, note]\n";
  const CameraFile file = read_camera_file(write("c.yaml", kClaim + warnings));
  EXPECT_EQ(write_camera_file(folder_ / "again.yaml", file, "tagcal"), std::vector<std::string>());
  const std::vector<Finding> again = read_calibration(folder_ / "again.yaml").findings;
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[0].code, "coverage");
  EXPECT_EQ(again[0].sentence, "no corners at the left");
  EXPECT_EQ(again[1].severity, Severity::note);
  const std::vector<std::string> notes = write_camera_file(folder_ / "c.txt", file, "ros");
  EXPECT_EQ(std::ranges::count(notes, "dropped: the warnings of the calibration"), 1);
  // Without warnings it does not say that there are none: the file of another program has not.
  write_camera_file(folder_ / "none.yaml", read_camera_file(write("d.yaml", kClaim)), "tagcal");
  EXPECT_LACKS(read_text(folder_ / "none.yaml"), "warnings");
}

// Files of older versions have no claim.
TEST_F(CameraUncertaintyTest, WithoutAClaimItIsTheCovariance) {
  const UncertainCamera claim = uncertain_camera(read(kPinhole));
  ASSERT_EQ(claim.model, &Model::named("pinhole"));
  EXPECT_EQ(claim.covariance, read(kPinhole).covariance);
  const std::string held =
      kPinhole.substr(0, kPinhole.find("covariance_names")) +
      "fixed: {fx: 900}\ncovariance: {rows: 3, cols: 3, data: [9, 1, 0, 1, 2, 0, 0, 0, 3]}\n";
  const UncertainCamera three = uncertain_camera(read(held));
  ASSERT_EQ(three.model, &Model::named("pinhole"));
  const Eigen::Vector4d variances(0, 9, 2, 3);
  EXPECT_EQ(three.covariance.diagonal(), variances);
  EXPECT_EQ(three.covariance(1, 2), 1);
  EXPECT_EQ(uncertain_camera(read(kPinhole.substr(0, kPinhole.find("covariance_n")))).model,
            nullptr);
}

TEST_F(CameraUncertaintyTest, AClaimThatIsNoneIsRefused) {
  const std::string good = "4, 1, 1, 0, 1, 9, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1";
  const std::vector<BadFile> table = {
      {"claim_model: pinhole", "claim_model: weak",
       "claim_model: must be one of f, f+c, pinhole, "},
      {"claim_model: pinhole", "claim_model: fisheye4",
       "claim_model: must have the kind of lens of model f+c, got fisheye4"},
      {"claim_model: pinhole\n", "",
       "claim_covariance: needs the key claim_model, which is missing"},
      {"claim_covariance", "x", "claim_model: needs the key claim_covariance, which is missing"},
      {"\ncovariance", "\nx", "claim_covariance: needs the key covariance, which is missing"},
      {"claim_model: pinhole", "claim_model: radial2",
       "claim_covariance: must be 5 x 5 with model radial2, got 4 x 4"},
      {"[fx, fy, cx, cy]", "[fy, fx, cx, cy]",
       "claim_names: must be fx, fy, cx, cy with model pinhole, got fy, fx, cx, cy"},
      {good, "4, 1, 1, 0, 2, 9, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1",
       "claim_covariance: must be symmetric, got 1 and 2"},
      {good, "4, 1, 1, 0, 1, 9, 0, 0, 1, 0, -1, 0, 0, 0, 0, 1",
       "claim_covariance: must have variances from 0 to 1e+100, got -1"},
      {good, "4, 1, 9, 0, 1, 9, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1",
       "claim_covariance: must be positive semi-definite"},
      {good, "5, 1, 1, 0, 1, 9, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1",
       "covariance: must be 4 for f and f by claim_covariance, got 3.75"},
      {good, "4, 1, 1, 0, 1, 9, 0, 0, 1, 0, 1, 0.5, 0, 0, 0.5, 1",
       "covariance: must be 0.5 for cx and cy by claim_covariance, got 0"}};
  for (const BadFile& bad : table)
    expect_line(error(replaced(kClaim, bad.from, bad.to)), bad.message);
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
