#pragma once

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace tagcal::tools {

using Json = nlohmann::json;

inline Pose pose_of(const Json& json) {
  const auto q = json["rotation"].get<std::vector<double>>();
  const auto t = json["translation_m"].get<std::vector<double>>();
  return {Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3)), {t.at(0), t.at(1), t.at(2)}};
}

inline Eigen::MatrixXd matrix_of(const Json& rows) {
  Eigen::MatrixXd m(rows.size(), rows.size());
  for (int r = 0; r < m.rows(); ++r)
    for (int c = 0; c < m.cols(); ++c) m(r, c) = rows[r][c];
  return m;
}

// The squared error in claimed standard deviations, 6 of them.
inline double normalised_error(const Json& view, const Pose& truth) {
  const Vector6d error = minus(pose_of(view["camera_from_board"]), truth);
  return error.dot(matrix_of(view["covariance"]).ldlt().solve(error));
}

class PoseCli : public Cli {
 protected:
  static std::string set() { return path("set"); }

  static Truth truth() { return read_truth(root() / "set" / "truth.yaml"); }

  // A calibration file with the true camera of the rendered set, or another width.
  static std::string camera_file(int width = 640) {
    const std::string file = path("camera-" + std::to_string(width) + ".yaml");
    spill(file,
          "image_width: " + std::to_string(width) +
              "\nimage_height: 400\n"
              "camera_matrix: {rows: 3, cols: 3, dt: d, "
              "data: [520, 0, 317, 0, 520, 203, 0, 0, 1]}\n"
              "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [-0.1, 0, 0, 0, 0]}\n");
    return file;
  }

  static std::string exact() { return " --observations " + path("set/observations_exact.csv"); }
  static std::string known() { return " --camera " + camera_file(); }

  static Json views_of(const std::string& arguments, int exit_code = 0) {
    const Outcome outcome = run("pose " + arguments + " --json");
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.out << outcome.err;
    return Json::parse(outcome.out)["views"];
  }

  // The command that docs/tasks/pose.md shows, and the text below it there; drawings go to
  // `drawings`.
  struct OnThePage {
    std::string arguments;
    std::string text;
  };
  static OnThePage on_the_page(const std::string& drawings) {
    const std::string source = TAGCAL_SOURCE_DIR;
    const std::string scene = source + "/data-synthetic/scenes/tabletop.yaml";
    EXPECT_EQ(run("render " + scene + " --force --out " + path("tabletop")).exit_code, 0);
    const std::string page = slurp(source + "/docs/tasks/pose.md");
    const std::string prompt = "\n$ tagcal ";
    const std::size_t begin = page.find(prompt + "pose") + prompt.size();
    const std::size_t end = page.find('\n', begin);
    std::string arguments = replaced(page.substr(begin, end - begin), "tabletop", path("tabletop"));
    return {replaced(arguments, "drawings", drawings),
            page.substr(end, page.find("```", end) - end)};
  }

  // A single tag, rendered once for all tests: from near and tilted, or far away and nearly
  // frontal.
  static std::string tag_set(bool far) {
    const std::string name = far ? "far-tag" : "near-tag";
    if (fs::exists(root() / name)) return path(name);
    spill(root() / (name + ".yaml"),
          std::string("camera: {image_size: [640, 400], model: f, f: 600}\n"
                      "boards:\n  - target: {target_type: tags, tags: [{id: 3, size: 0.1}]}\n"
                      "    world_from_board: {translation_m: [1, 2, 0]}\n"
                      "path: {type: line, target_m: [1, 2, 0], ") +
              (far ? "from_m: [1.5, 2, 1.7], to_m: [1, 2.6, 1.8]}"
                   : "from_m: [1.25, 2, 0.2], to_m: [1, 2.3, 0.2]}") +
              "\nviews: 2\n");
    EXPECT_EQ(run("render " + path(name + ".yaml") + " --out " + path(name)).exit_code, 0);
    spill(root() / (name + "-camera.yaml"),
          "image_width: 640\nimage_height: 400\ncamera_matrix: {rows: 3, cols: 3, dt: d, "
          "data: [600, 0, 319.5, 0, 600, 199.5, 0, 0, 1]}\n"
          "distortion_coefficients: {rows: 1, cols: 4, dt: d, data: [0, 0, 0, 0]}\n");
    return path(name);
  }
};

}  // namespace tagcal::tools
