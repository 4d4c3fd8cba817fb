// `tagcal pose --out`: the poses of a bag's frames as files.
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli_fixture.hpp"
#include "mcap_writer.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

class CliPoseOut : public Cli {
 protected:
  // A bag of three pictures of a board, at 10 Hz from 1000.1 s on; the last one shows nothing.
  void SetUp() override {
    spill(root() / "scene.yaml",
          "camera: {image_size: [320, 240], model: f, f: 270}\n"
          "boards:\n"
          "  - target: {target_type: aprilgrid, tagCols: 3, tagRows: 3, tagSize: 0.08, tagSpacing: "
          "0.3}\n"
          "path: {type: ring, radius_m: 0.3, centre_m: [0.15, 0.15, 0.6], end_deg: 60, target_m: "
          "[0.15, 0.15, 0]}\n"
          "views: 2\nsensor: {blur_px: 0.6, noise_levels: 1}\n");
    good_run("render " + path("scene.yaml") + " --force --out " + path("set"));
    McapWriter bag("/camera/image_raw");
    double time_s = 1000;
    std::vector<fs::path> pictures = list_pictures(root() / "set/images");
    for (const fs::path& picture : pictures)
      bag.add(McapWriter::message(read_image(picture), time_s += 0.1));
    const Image8 empty({320, 240}, 128);
    bag.add(McapWriter::message(empty, time_s + 0.1));
    spill(root() / "a.mcap", bag.bytes());
    for (const auto& [image, pose] : read_truth(root() / "set/truth.yaml").camera_from_world)
      world_from_camera_.push_back(pose.inverse());
  }

  Outcome pose(const std::string& out, const std::string& more = "") {
    return run("pose --target " + path("set/target.yaml") + " --camera " + path("set/truth.yaml") +
               " " + path("a.mcap") + " --out " + path(out) + " " + more);
  }

  std::vector<std::string> lines_of(const std::string& file) {
    std::vector<std::string> lines;
    std::istringstream text(slurp(path(file)));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

  std::vector<Pose> world_from_camera_;
};

TEST_F(CliPoseOut, ATableHasALineAFrame) {
  const Outcome out = pose("p.csv");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  EXPECT_HAS(out.err, "wrote " + path("p.csv"));
  const std::vector<std::string> lines = lines_of("p.csv");
  ASSERT_EQ(lines.size(), 4U);
  std::vector<std::string> names;
  CsvFields fields;
  fields.split(lines[0]);
  for (const std::string_view name : fields.fields()) names.emplace_back(name);
  ASSERT_EQ(names.size(), 23U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(fields.split(lines[i + 1]), "");
    ASSERT_EQ(fields.fields().size(), names.size());
    std::map<std::string, std::string> row;
    for (std::size_t k = 0; k < names.size(); ++k) row[names[k]] = fields.fields()[k];
    const auto number = [&](const std::string& name) { return std::stod(row.at(name)); };
    EXPECT_EQ(row["image"], "a@00000" + std::to_string(i));
    EXPECT_EQ(row["time_s"], "1000." + std::to_string(i + 1) + "00000");
    EXPECT_EQ(row["status"], "ok");
    EXPECT_EQ(row["num_inliers"], "36");
    const Pose found({number("qw"), number("qx"), number("qy"), number("qz")},
                     {number("x_m"), number("y_m"), number("z_m")});
    const Eigen::Vector3d error = found.translation() - world_from_camera_[i].translation();
    const Eigen::Vector3d sigma(number("sigma_x_m"), number("sigma_y_m"), number("sigma_z_m"));
    EXPECT_LT(error.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 5);
    EXPECT_LT(sigma.maxCoeff(), 0.002);
    EXPECT_LT(found.rotation().angularDistance(world_from_camera_[i].rotation()),
              5 * (number("sigma_rx_rad") + number("sigma_ry_rad") + number("sigma_rz_rad")));
  }
  EXPECT_EQ(lines[3], "a@000002,1000.300000,degenerate,,,,,,,,,,,,,,,,,,,0,target_unseen");
}

TEST_F(CliPoseOut, APathHasTheTimesOfTheFrames) {
  const Outcome out = pose("p.tum");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  EXPECT_HAS(out.err, "timestamps are the times of the pictures");
  EXPECT_HAS(out.err, ": 2 poses of 3 views");
  const std::vector<std::string> lines = lines_of("p.tum");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], "# timestamp tx ty tz qx qy qz qw (target from camera)");
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(lines[2].c_str(), "1000.200000 %lf %lf %lf", &x, &y, &z), 3) << lines[2];
  EXPECT_LT((Eigen::Vector3d(x, y, z) - world_from_camera_[1].translation()).norm(), 0.005);
  // It is a robot's path for others.
  good_run("pose --target " + path("set/target.yaml") + " " + path("set/images") +
           " --unknown-focal --out " + path("q.tum"));
}

TEST_F(CliPoseOut, ABagHasTheCameraAndItsFindings) {
  const Outcome out = pose("p.mcap", "--sigma-px 0.001");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const std::string bytes = slurp(path("p.mcap"));
  for (const char* const part :
       {"foxglove.CameraCalibration", "foxglove.FrameTransform", R"("sec":1000,"nsec":100000000)",
        R"("parent_frame_id":"world")", R"("name":"noise_understated")"})
    EXPECT_HAS(bytes, part);
}

// Times stay with the corners and with the answer, and serve `handeye`.
TEST_F(CliPoseOut, TimesStay) {
  good_run("detect " + path("a.mcap") + " --no-cache --target " + path("set/target.yaml") +
           " --out " + path("c.csv"));
  spill(root() / "set/dataset.yaml",
        "image_size: [320, 240]\ntarget: target.yaml\nobservations: ../c.csv\n");
  const Outcome out = good_run("pose " + path("set") + " --camera " + path("set/truth.yaml") +
                               " --json --out " + path("p.json"));
  EXPECT_EQ(out.out, slurp(path("p.json")));
  const auto views = nlohmann::json::parse(out.out)["views"];
  EXPECT_EQ(views[1]["time_s"], 1000.2);
  good_run("report " + path("p.json") + " --dataset " + path("set") + " --out " + path("p.html"));
  EXPECT_HAS(slurp(path("p.html")), R"("image":"a@000001","time_s":1000.2,)");
  good_run("convert " + path("set/truth.yaml") + " " + path("r.tum") + " --poses " +
           path("p.json"));
  EXPECT_EQ(lines_of("r.tum").at(0), "# timestamp tx ty tz qx qy qz qw (target from camera)");
  EXPECT_EQ(lines_of("r.tum").at(2).substr(0, 12), "1000.200000 ");
}

TEST_F(CliPoseOut, BadNamesAreOneLine) {
  const auto refuses = [&](const Outcome& out, const std::string& part) {
    EXPECT_EQ(out.exit_code, 2) << out.err;
    EXPECT_HAS(out.err, part);
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
  };
  refuses(pose("p.txt"), "--out: must end in .csv, .json, .tum or .mcap");
  const std::string camera = " --camera " + path("set/truth.yaml");
  refuses(run("pose " + path("set") + camera + " --out -"), "--out: - is standard output");
  refuses(pose("a.mcap"), "a.mcap");
  refuses(pose("none/p.csv"), "none");
  const std::string images = path("set/images");
  refuses(run("pose --target " + path("set/target.yaml") + " " + images +
              " --unknown-focal --out " + path("p.mcap")),
          "holds the camera of --camera");
  refuses(run("pose --family tag36h11 --border-bits 2 --tag-size 0.08 " + images + " --camera " +
              path("set/truth.yaml") + " --out " + path("p.tum")),
          "holds one pose of a picture");
  // Nothing is written of pictures without an answer.
  const Outcome none =
      run("pose --target " + path("set/target.yaml") + " " + images + " --exclude '0*' --camera " +
          path("set/truth.yaml") + " --out " + path("n.csv"));
  EXPECT_NE(none.exit_code, 0);
  EXPECT_FALSE(fs::exists(path("n.csv")));
  const Outcome tags =
      good_run("pose --family tag36h11 --border-bits 2 --tag-size 0.08 " + images + " --camera " +
               path("set/truth.yaml") + " --out " + path("tags.csv"));
  EXPECT_GT(lines_of("tags.csv").size(), 1U + 9);
  EXPECT_LACKS(tags.err, "m wide");
  const Outcome wide = run("pose --family tag36h11 --border-bits 2 --tag-size 80 " + images +
                           " --camera " + path("set/truth.yaml"));
  EXPECT_HAS(wide.err, "--tag-size: a tag is 80 m wide");
}

}  // namespace
}  // namespace tagcal::tools
