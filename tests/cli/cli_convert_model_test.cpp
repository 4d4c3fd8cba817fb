#include "cli_fixture.hpp"

// `convert --model` from outside: a lens of one model for that of another.

namespace tagcal::tools {
namespace {

constexpr const char* kDoubleSphere = R"(cam0:
  camera_model: ds
  intrinsics: [-0.17213086034353243, 0.5931177593944744, 158.28600034966977, 158.2743455478755, 254.96116578191653, 256.8894394501779]
  distortion_model: none
  distortion_coeffs: []
  resolution: [512, 512]
)";

class ConvertModel : public Cli {
 protected:
  void SetUp() override { spill(root() / "ds.yaml", kDoubleSphere); }

  // The arguments of a conversion of a file.
  static std::string convert(const std::string& in, const std::string& out,
                             const std::string& more) {
    return "convert " + path(in) + " " + path(out) + " --to tagcal " + more;
  }
};

TEST_F(ConvertModel, ADoubleSphereBecomesAFisheye) {
  const Outcome outcome =
      good_run(convert("ds.yaml", "kb.yaml", "--model fisheye4 --picture " + path("d.svg")));
  EXPECT_HAS(outcome.out, "model fisheye4 for the double sphere lens");
  EXPECT_HAS(outcome.out, "  whole image         0.000");
  EXPECT_LACKS(outcome.out, "+-");  // nothing is known about the source
  const std::string file = slurp(root() / "kb.yaml");
  EXPECT_HAS(file, "model: \"fisheye4\"");
  EXPECT_LACKS(file, "covariance");
  const std::string svg = slurp(root() / "d.svg");
  EXPECT_HAS(svg, "<svg ");
  good_run(convert("ds.yaml", "kb.yaml", "--model fisheye4 --picture " + path("d.png")));
  EXPECT_TRUE(slurp(root() / "d.png").starts_with("\x89PNG"));
}

// Through the formats that have it, and back.
TEST_F(ConvertModel, ADoubleSphereIsKept) {
  ASSERT_EQ(run(convert("ds.yaml", "ours.yaml", "")).exit_code, 0);
  EXPECT_HAS(slurp(root() / "ours.yaml"), "model: \"ds\"");
  const std::string there = "convert " + path("ours.yaml") + " ";
  ASSERT_EQ(run(there + path("b.json") + " --to basalt").exit_code, 0);
  EXPECT_HAS(slurp(root() / "b.json"), "\"camera_type\": \"ds\"");
  ASSERT_EQ(run("convert " + path("b.json") + " " + path("k.yaml") + " --to kalibr").exit_code, 0);
  good_run("diff " + path("k.yaml") + " " + path("ds.yaml"));
  EXPECT_HAS(slurp(root() / "k.yaml"), "intrinsics: [-0.1721308603435324");
}

TEST_F(ConvertModel, ALensThatTheModelDoesNotDescribeIsAFailedCheck) {
  fs::remove(root() / "five.yaml");
  const Outcome outcome =
      run(convert("ds.yaml", "five.yaml", "--model opencv5 --picture " + path("five.svg")));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_HAS(outcome.err, "model opencv5 has no projection for ");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(fs::exists(root() / "five.yaml"));
  EXPECT_TRUE(fs::exists(root() / "five.svg"));
}

TEST_F(ConvertModel, ACalibrationKeepsItsStandardDeviations) {
  good_run("calibrate " + path("set") + " --observations " + path("set/observations_exact.csv") +
           " --model radial1 --out " + path("radial1.yaml"));
  const Outcome wide = good_run(convert("radial1.yaml", "larger.yaml", "--model opencv4"));
  EXPECT_HAS(wide.out, "model opencv4 for the lens of model radial1");
  EXPECT_HAS(wide.out, "  where corners were  ");
  EXPECT_HAS(wide.out, " +- ");
  // The file is a calibration like any other.
  EXPECT_EQ(run("diff " + path("radial1.yaml") + " " + path("larger.yaml")).exit_code, 0);
  const Outcome small = run(convert("radial1.yaml", "small.yaml", "--model f+c"));
  EXPECT_EQ(small.exit_code, 1);
  EXPECT_HAS(small.err, "over the part of the image that had corners, more than 0.1 px");
  good_run(convert("radial1.yaml", "small.yaml", "--model f+c --max-difference-px 100"));
}

// A fixed parameter may have a value that its model does not have otherwise.
TEST_F(ConvertModel, ACalibrationWithAFixedParameterIsRead) {
  good_run("calibrate " + path("set") + " --observations " + path("set/observations_exact.csv") +
           " --model radial1 --fix k2=0.001 --out " + path("fixed.yaml"));
  good_run(convert("fixed.yaml", "free.yaml", "--model radial2"));
}

TEST_F(ConvertModel, BadOptions) {
  const auto bad = [](const std::string& more, const std::vector<std::string>& parts) {
    expect_bad_input(convert("ds.yaml", "no.yaml", more), parts);
    EXPECT_FALSE(fs::exists(root() / "no.yaml"));
  };
  bad("--model fisheye5", {"--model", "opencv4", "fisheye5"});
  bad("--model weak", {"--model", "weak", "--model: must be f, f+c, "});
  bad("--max-difference-px 1", {"--max-difference-px: needs --model"});
  bad("--picture a.svg", {"--picture: needs --model"});
  bad("--model f --picture a.gif", {"a.gif", ".svg or .png"});
  bad("--model f --max-difference-px 0", {"--max-difference-px"});
  expect_bad_input("convert " + path("ds.yaml") + " " + path("no.yaml") + " --to ros",
                   {"ros has no double sphere lens", "--model fisheye4 fits one that it has"});
}

}  // namespace
}  // namespace tagcal::tools
