// Positions in the drawing of `tagcal view --svg`, against the projection by formulas of this file.
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "cli_fixture.hpp"
#include "view_json.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Json = nlohmann::json;

constexpr double kRounded = 0.02;  // px: coordinates have two decimals

const std::string kDoorway = std::string(TAGCAL_SOURCE_DIR) + "/data-synthetic/scenes/doorway.yaml";

std::vector<double> numbers(std::string text) {
  std::ranges::replace(text, ',', ' ');
  std::istringstream stream(text);
  return std::vector<double>(std::istream_iterator<double>(stream), {});
}

// The elements of a drawing by their id, and the outside camera.
class Drawing {
 public:
  explicit Drawing(std::string svg) : svg_(std::move(svg)) {
    const auto lens = numbers(attribute("scene-drawing", "data-lens"));
    focal_ = lens.at(0);
    centre_ = {lens.at(1), lens.at(2)};
    const auto pose = numbers(attribute("scene-drawing", "data-camera-from-world"));
    camera_from_world_ =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(pose.data());
  }

  const std::string& svg() const { return svg_; }
  bool has(const std::string& id) const {
    return svg_.find("id=\"" + id + "\"") != std::string::npos;
  }

  std::string attribute(const std::string& id, const std::string& name) const {
    const std::size_t at = svg_.find("id=\"" + id + "\"");
    EXPECT_NE(at, std::string::npos) << id;
    if (at == std::string::npos) return "";
    const std::size_t end = svg_.find('>', at);
    const std::size_t begin = svg_.find(" " + name + "=\"", at);
    EXPECT_LT(begin, end) << id << " " << name;
    if (begin >= end) return "";
    const std::size_t value = begin + name.size() + 3;
    return svg_.substr(value, svg_.find('"', value) - value);
  }

  double number(const std::string& id, const std::string& name) const {
    return numbers(attribute(id, name)).at(0);
  }
  Vector2d centre(const std::string& id) const { return {number(id, "cx"), number(id, "cy")}; }
  Vector2d start(const std::string& id) const { return {number(id, "x1"), number(id, "y1")}; }
  Vector2d end(const std::string& id) const { return {number(id, "x2"), number(id, "y2")}; }
  std::vector<Vector2d> points(const std::string& id) const {
    const auto values = numbers(attribute(id, "points"));
    std::vector<Vector2d> points;
    for (std::size_t i = 0; i + 1 < values.size(); i += 2)
      points.emplace_back(values[i], values[i + 1]);
    return points;
  }

  // The place of a point of the world in the panel of the scene.
  Vector2d seen(const Vector3d& x) const {
    const Vector3d c = camera_from_world_ * x.homogeneous();
    return focal_ * c.head<2>() / c.z() + centre_;
  }

  // The boxes left, bottom, right, top of all names in a panel.
  std::vector<std::vector<double>> boxes(const std::string& panel) const {
    const std::size_t begin = svg_.find("<g id=\"" + panel + "-labels\"");
    const std::string text = svg_.substr(begin, svg_.find("</g>", begin) - begin);
    std::vector<std::vector<double>> boxes;
    for (std::size_t at = text.find("data-box=\""); at != std::string::npos;
         at = text.find("data-box=\"", at + 1))
      boxes.push_back(numbers(text.substr(at + 10, text.find('"', at + 10) - at - 10)));
    return boxes;
  }

 private:
  std::string svg_;
  double focal_ = 0;
  Vector2d centre_;
  Eigen::Matrix<double, 3, 4> camera_from_world_;
};

void expect_at(const Vector2d& expected, const Vector2d& actual) {
  EXPECT_LT((expected - actual).norm(), kRounded)
      << expected.transpose() << " against " << actual.transpose();
}

Vector3d in_world(const Json& answer, const Vector3d& x_in_eye) {
  const Json& m = answer["matrices"];
  const Eigen::Matrix4d eye_from_world =
      matrix(m["eye_from_camera"]) * matrix(m["camera_from_world"]);
  return (eye_from_world.inverse() * x_in_eye.homogeneous()).head<3>();
}

// Corners of the volume's section at a depth, counter-clockwise from the lower left.
std::vector<Vector3d> section(const Json& answer, double depth) {
  const Json& v = answer["view_volume"];
  const double s = v["projection"] == "parallel" ? 1 : depth / v["near_m"].get<double>();
  std::vector<Vector3d> result;
  for (const auto& [x, y] : {std::pair("left", "bottom"), std::pair("right", "bottom"),
                             std::pair("right", "top"), std::pair("left", "top")})
    result.push_back(in_world(answer, {s * v[x].get<double>(), s * v[y].get<double>(), -depth}));
  return result;
}

void expect_plane(const Drawing& drawing, const Json& answer, const std::string& id, double depth) {
  const auto corners = section(answer, depth);
  const auto points = drawing.points(id);
  ASSERT_EQ(points.size(), 4U) << id;
  for (std::size_t i = 0; i < 4; ++i) expect_at(drawing.seen(corners[i]), points[i]);
}

void expect_axes(const Drawing& drawing, const std::string& frame,
                 const Eigen::Matrix4d& world_from_frame) {
  const Vector3d origin = world_from_frame.col(3).head<3>();
  for (int axis = 0; axis < 3; ++axis) {
    const std::string id = "axis-" + frame + "-" + "xyz"[axis];
    SCOPED_TRACE(id);
    expect_at(drawing.seen(origin), drawing.start(id));
    // Any point of the axis shows its direction.
    const Vector2d along =
        drawing.seen(origin + 0.01 * world_from_frame.col(axis).head<3>()) - drawing.seen(origin);
    const Vector2d drawn = drawing.end(id) - drawing.start(id);
    EXPECT_GT(along.dot(drawn), 0);
    EXPECT_LT(std::abs(along.x() * drawn.y() - along.y() * drawn.x()) / along.norm(), 2 * kRounded);
  }
}

// A drawing and the numbers that belong to it.
class ViewDrawing : public Cli {
 protected:
  void view(const std::string& arguments) {
    SCOPED_TRACE(arguments);
    const Outcome svg = run("view " + arguments + " --svg"),
                  json = run("view " + arguments + " --json");
    // Without a drawing the rest of a test has nothing to look at, so it ends here.
    if (svg.exit_code != 0) throw std::runtime_error(svg.err);
    if (json.exit_code != 0) throw std::runtime_error(json.err);
    answer_ = Json::parse(json.out);
    drawing_.emplace(svg.out);
  }

  void expect_positions() const {
    const Json& p = answer_["point"];
    const Json& v = answer_["view_volume"];
    if (drawing_->has("near")) expect_plane(*drawing_, answer_, "near", v["near_m"]);
    if (drawing_->has("far")) expect_plane(*drawing_, answer_, "far", v["far_m"]);
    expect_at(drawing_->seen(vector(p["in_world_m"])), drawing_->centre("point"));
    EXPECT_EQ(drawing_->has("hit"), !p["hit_in_world_m"].is_null());
    if (drawing_->has("hit"))
      expect_at(drawing_->seen(vector(p["hit_in_world_m"])), drawing_->centre("hit"));
    expect_axes(*drawing_, "world", Eigen::Matrix4d::Identity());
    expect_axes(*drawing_, "camera", matrix(answer_["matrices"]["camera_from_world"]).inverse());
    expect_image_point();
    expect_pixel();
    expect_ndc();
  }

  // Where the line of sight pierces the drawn image plane.
  void expect_image_point() const {
    const double depth = drawing_->number("scene-drawing", "data-image-depth");
    expect_plane(*drawing_, answer_, "image-plane", depth);
    if (!drawing_->has("image-point")) return;
    const Vector3d x = vector(answer_["point"]["in_eye_m"]);
    const bool parallel = answer_["view_volume"]["projection"] == "parallel";
    const Vector3d pierced =
        parallel ? Vector3d(x.x(), x.y(), -depth) : Vector3d(-depth / x.z() * x);
    expect_at(drawing_->seen(in_world(answer_, pierced)), drawing_->centre("image-point"));
  }

  void expect_pixel() const {
    const Json& p = answer_["point"];
    if (!drawing_->has("pixel")) return;
    const Vector2d origin(drawing_->number("image-drawing", "x"),
                          drawing_->number("image-drawing", "y"));
    const double sx =
        drawing_->number("image-drawing", "width") / answer_["image_size"][0].get<double>();
    const double sy =
        drawing_->number("image-drawing", "height") / answer_["image_size"][1].get<double>();
    const auto place = [&](const Json& pixel) {
      return Vector2d(origin + Vector2d(sx * (pixel[0].get<double>() + 0.5),
                                        sy * (pixel[1].get<double>() + 0.5)));
    };
    expect_at(place(p["pixel"]), drawing_->centre("pixel"));
    if (drawing_->has("raster")) expect_at(place(p["in_raster_px"]), drawing_->centre("raster"));
  }

  // The cube is a cabinet projection: depth is drawn at half its length; the point lies in it by
  // its three coordinates.
  void expect_ndc() const {
    const auto near = drawing_->points("ndc-near"), far = drawing_->points("ndc-far");
    ASSERT_EQ(near.size(), 4U);
    const Vector2d x = (near[1] - near[0]) / 2, y = (near[3] - near[0]) / 2;
    const Vector2d z = (far[0] - near[0]) / 2;
    EXPECT_NEAR(z.norm(), x.norm() / 2, kRounded);
    EXPECT_NEAR(x.norm(), y.norm(), kRounded);
    if (!drawing_->has("ndc-point")) return;
    const Vector3d ndc = vector(answer_["point"]["in_ndc"]);
    const Vector2d middle = (near[0] + far[2]) / 2;
    expect_at(middle + ndc.x() * x + ndc.y() * y + ndc.z() * z, drawing_->centre("ndc-point"));
  }

  void expect_names_apart() const {
    for (const std::string panel : {"scene", "image", "ndc"}) {
      const auto size = numbers(drawing_->attribute(panel, "data-size"));
      const auto boxes = drawing_->boxes(panel);
      EXPECT_FALSE(boxes.empty()) << panel;
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const auto& a = boxes[i];
        EXPECT_TRUE(a[0] >= 0 && a[1] >= 0 && a[2] <= size[0] && a[3] <= size[1]) << panel << i;
        for (std::size_t k = 0; k < i; ++k) {
          const auto& b = boxes[k];
          EXPECT_FALSE(a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3])
              << panel << " " << i << " " << k;
        }
      }
    }
  }

  void expect_named(const std::vector<std::string>& names) const {
    for (const std::string& name : names) EXPECT_HAS(drawing_->svg(), ">" + name + "</text>");
  }

  Json answer_;
  std::optional<Drawing> drawing_;
};

TEST_F(ViewDrawing, TheDoorwayIsWhereItIs) {
  view(kDoorway + " --at 1:2 --near 1 --far 10");
  expect_positions();
  expect_names_apart();
  expect_named({"near plane, 1 m", "far plane, 10 m", "world", "camera", "board 1", "board 0",
                "occluder 0", "occluder 3", "stopped by occluder 1", "image point",
                "tag 1 corner 2", "(-0.5, -0.5)", "(639.5, 479.5)", "far, z = 1"});
  EXPECT_TRUE(drawing_->has("near") && drawing_->has("far"));
  // The wall is at y = 2, half way to the point.
  EXPECT_LT((vector(answer_["point"]["hit_in_world_m"]) - Vector3d(0.9, 2, 1.2)).norm(), 1e-9);
  expect_axes(*drawing_, "board 1", matrix(answer_["matrices"]["world_from_board"]));
}

TEST_F(ViewDrawing, NearAndFarMoveTheirPlanes) {
  for (const std::string planes :
       {"--near 0.5 --far 4.5", "--near 2 --far 6", "--near 3 --far 9"}) {
    view(kDoorway + " --at 0:2 " + planes);
    EXPECT_TRUE(drawing_->has("near") && drawing_->has("far")) << planes;
    expect_positions();
  }
  view(kDoorway + " --at 0:2 --near 0.5 --far 1000");
  EXPECT_TRUE(drawing_->has("near"));
  EXPECT_FALSE(drawing_->has("far"));
  EXPECT_HAS(drawing_->svg(), "far plane at 1000 m: beyond the drawing");
  expect_positions();
  expect_names_apart();
  view(kDoorway + " --at 0:2 --near 50 --far 100");
  EXPECT_FALSE(drawing_->has("near"));
  EXPECT_HAS(drawing_->svg(), "near plane at 50 m, far plane at 100 m: beyond");
}

TEST_F(ViewDrawing, ScenesOfAllKinds) {
  const std::string frames =
      "frames: [{name: table, pose: {translation_m: [0.1, 0, 0.1]}}, {name: 'a<b', parent: table, "
      "pose: {roll_pitch_yaw_deg: [10, 20, 30]}}]\n"
      "cuboids: [{size_m: [0.05, 0.05, 0.1], frame: 'a<b'}]\n";
  spill(root() / "frames.yaml", kScene + frames);
  const std::string lens = "model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]";
  spill(root() / "wide.yaml", replaced(kScene, lens, "model: fisheye4, f: 200"));
  spill(root() / "oblique.yaml",
        replaced(kScene, lens, "model: parallel, scale_px_per_m: 900, projection: cabinet"));
  for (const std::string& input :
       {path("frames.yaml") + " --view 3", path("wide.yaml"), path("oblique.yaml") + " --at 5:1",
        path("set") + " --view 2", path("scene.yaml") + " --at 0.1,0.1,0.3",
        path("wide.yaml") + " --at 0,0,5"}) {
    SCOPED_TRACE(input);
    view(input);
    expect_positions();
    expect_names_apart();
  }
  view(path("frames.yaml"));
  expect_named({"table", "a&lt;b", "cuboid 0"});
  view(path("wide.yaml"));
  EXPECT_HAS(drawing_->svg(), "of the pinhole with the same focal length on the axis");
}

}  // namespace
}  // namespace tagcal::tools
