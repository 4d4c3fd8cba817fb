// Positions in the drawing of `tagcal view --svg`, against the projection by formulas of this file.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <optional>
#include <span>

#include "cli_fixture.hpp"
#include "draw/canvas.hpp"
#include "draw/outside_view.hpp"
#include "draw/scene_drawing.hpp"
#include "draw/view_panels.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal::tools {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using study::Drawing, study::Path, study::Text;

constexpr double kRounded = 1e-6;  // px
constexpr PanelSize kPanel{760, 600};

const std::string kDoorway = std::string(TAGCAL_SOURCE_DIR) + "/data-synthetic/scenes/doorway.yaml";

std::vector<Path> paths(const Drawing& drawing, std::string_view colour) {
  std::vector<Path> found;
  for (const auto& item : drawing.items)
    if (const auto* path = std::get_if<Path>(&item); path && path->colour == colour)
      found.push_back(*path);
  return found;
}

AlignedBox2d box_of(const std::vector<Vector2d>& points) {
  AlignedBox2d box;
  for (const Vector2d& p : points) box.extend(p);
  return box;
}

// The middles of the discs, or else of the rings.
std::vector<Vector2d> circles(const Drawing& drawing, std::string_view colour, double radius,
                              bool is_disc) {
  std::vector<Vector2d> middles;
  for (const Path& path : paths(drawing, colour)) {
    const AlignedBox2d box = box_of(path.points);
    if (path.points.size() > 20 && (path.width == 0) == is_disc &&
        (box.sizes() - Vector2d::Constant(2 * radius)).norm() < 0.01)
      middles.push_back(box.center());
  }
  return middles;
}

bool is_among(const Vector2d& expected, const std::vector<Vector2d>& points) {
  return std::ranges::any_of(points,
                             [&](const auto& p) { return (p - expected).norm() < kRounded; });
}

// If a closed line of this colour passes through these corners.
bool has_outline(const Drawing& drawing, std::string_view colour,
                 const std::vector<Vector2d>& corners) {
  return std::ranges::any_of(paths(drawing, colour), [&](const Path& path) {
    return path.width > 0 && path.points.size() == corners.size() + 1 &&
           path.points.front() == path.points.back() &&
           std::ranges::equal(
               corners, std::span(path.points).first(corners.size()),
               [](const auto& a, const auto& b) { return (a - b).norm() < kRounded; });
  });
}

bool has_name(const Drawing& drawing, std::string_view name) {
  return std::ranges::any_of(drawing.items, [&](const auto& item) {
    const auto* text = std::get_if<Text>(&item);
    return text && text->text == name;
  });
}

// A view of a scene and its drawing.
class Viewed {
 public:
  Viewed(const fs::path& file, int view, const std::string& at, std::optional<NearFar> planes = {})
      : moving_(read_moving_scene(file)), scene_(scene_in_view(moving_, view)) {
    const Pose pose = camera_poses(moving_, 0)[static_cast<std::size_t>(view)];
    if (!planes) planes = enclosing_planes(scene_, pose);
    const auto pipeline = viewing_pipeline(scene_.camera, pose, planes->near_m, planes->far_m);
    const NamedPoint point = point_of(at);
    report_.emplace(ViewReport{scene_, "000.png", pipeline, point,
                               followed(point, scene_, pipeline), frames_in_view(moving_, view),
                               moving_.boards});
    panel_ = scene_panel(*report_, kPanel);
    outside_.emplace(*report_);
  }

  const ViewReport& report() const { return *report_; }
  const Drawing& panel() const { return panel_; }
  double image_depth() const { return outside_->image_depth_m(); }
  double drawn_depth() const { return outside_->drawn_depth_m(); }

  // The place of a point of the world in the panel of the scene.
  Vector2d seen(const Vector3d& x) const {
    const Camera outside = outside_->camera(kPanel);
    const auto lens = parameters(outside.lens);
    const Vector3d c = outside_->camera_from_world() * x;
    return lens[0] * c.head<2>() / c.z() + Vector2d(lens[2], lens[3]);
  }

  Vector3d in_world(const Vector3d& x_in_eye) const {
    const ViewingPipeline& p = report_->pipeline;
    const Eigen::Matrix4d eye_from_world = p.eye_from_camera * p.camera_from_world.matrix();
    return (eye_from_world.inverse() * x_in_eye.homogeneous()).head<3>();
  }

  // If the volume's section at a depth is drawn: its corners, counter-clockwise from the lower
  // left.
  bool has_section(std::string_view colour, double depth) const {
    const ViewVolume& v = report_->pipeline.volume;
    const double s = v.projection == Projection::parallel ? 1 : depth / v.near_m;
    std::vector<Vector2d> corners;
    for (const auto& [x, y] :
         {std::pair(v.window.left, v.window.bottom), std::pair(v.window.right, v.window.bottom),
          std::pair(v.window.right, v.window.top), std::pair(v.window.left, v.window.top)})
      corners.push_back(seen(in_world({s * x, s * y, -depth})));
    return has_outline(panel_, colour, corners);
  }
  bool has_near() const { return has_section(kVolumeColour, report_->pipeline.volume.near_m); }
  bool has_far() const { return has_section(kVolumeColour, report_->pipeline.volume.far_m); }

  void expect_positions() const {
    const FollowedPoint& f = report_->followed;
    EXPECT_EQ(has_near(), report_->pipeline.volume.near_m <= drawn_depth());
    EXPECT_EQ(has_far(), report_->pipeline.volume.far_m <= drawn_depth());
    EXPECT_TRUE(is_among(seen(f.in_world), circles(panel_, kPointColour, 4, true)));
    const auto hits = circles(panel_, "#ffffff", 4.5, true);
    EXPECT_EQ(hits.size(), f.hit_in_world ? 1U : 0U);
    if (f.hit_in_world) EXPECT_TRUE(is_among(seen(*f.hit_in_world), hits));
    expect_axes(Eigen::Affine3d::Identity());
    const Eigen::Affine3d camera(report_->pipeline.camera_from_world.inverse().matrix());
    expect_axes(camera);
    expect_image_point();
    expect_pixel();
    expect_ndc();
  }

  void expect_axes(const Eigen::Affine3d& world_from_frame) const {
    const Vector2d origin = seen(world_from_frame.translation());
    for (int axis = 0; axis < 3; ++axis) {
      // Any point of the axis shows its direction.
      const Vector2d along =
          (seen(world_from_frame * Vector3d(0.01 * Vector3d::Unit(axis))) - origin).normalized();
      EXPECT_TRUE(std::ranges::any_of(paths(panel_, kAxisColours[axis]), [&](const Path& path) {
        const Vector2d drawn = path.points.back() - path.points.front();
        return (path.points.front() - origin).norm() < kRounded && along.dot(drawn) > 0 &&
               std::abs(along.x() * drawn.y() - along.y() * drawn.x()) < kRounded;
      })) << axis;
    }
  }

  // Where the line of sight pierces the drawn image plane.
  void expect_image_point() const {
    const double depth = image_depth();
    EXPECT_TRUE(has_section(kPlaneColour, depth));
    const auto image = circles(panel_, kPlaneColour, 3, true);
    if (image.empty()) return;
    const Vector3d x = report_->followed.in_eye;
    const bool parallel = report_->pipeline.volume.projection == Projection::parallel;
    const Vector3d pierced =
        parallel ? Vector3d(x.x(), x.y(), -depth) : Vector3d(-depth / x.z() * x);
    EXPECT_TRUE(is_among(seen(in_world(pierced)), image));
  }

  // The first item of the panel is the image's background.
  void expect_pixel() const {
    const FollowedPoint& f = report_->followed;
    const ImageSize& whole = report_->pipeline.camera.image_size;
    const Drawing image = image_panel(*report_, kPanel);
    const AlignedBox2d drawn = box_of(std::get<Path>(image.items.front()).points);
    const Vector2d scale = drawn.sizes().cwiseQuotient(Vector2d(whole.width, whole.height));
    const auto place = [&](const Vector2d& pixel) {
      return Vector2d(drawn.min() + scale.cwiseProduct(pixel + Vector2d::Constant(0.5)));
    };
    if (!f.pixel || !contains(whole, *f.pixel)) return;
    EXPECT_TRUE(is_among(place(*f.pixel),
                         circles(image, kPointColour, 3, report_->followed.sight == Sight::seen)));
    for (const Vector2d& raster : circles(image, kPointColour, 6, false))
      EXPECT_LT((raster - place(*f.in_raster_px)).norm(), kRounded);
  }

  // The cube is a cabinet projection: depth is drawn at half its length; the point lies in it by
  // its three coordinates.
  void expect_ndc() const {
    const Drawing cube = ndc_panel(*report_, kPanel);
    std::vector<std::vector<Vector2d>> faces;  // far, near
    for (const Path& path : paths(cube, kVolumeColour))
      if (path.points.size() == 5) faces.push_back(path.points);
    ASSERT_EQ(faces.size(), 2U);
    const auto& far = faces[0];
    const auto& near = faces[1];
    const Vector2d x = (near[1] - near[0]) / 2, y = (near[3] - near[0]) / 2;
    const Vector2d z = (far[0] - near[0]) / 2;
    EXPECT_NEAR(z.norm(), x.norm() / 2, kRounded);
    EXPECT_NEAR(x.norm(), y.norm(), kRounded);
    const auto points = circles(cube, kPointColour, 4, true);
    if (points.empty()) return;
    const Vector3d ndc = report_->followed.in_ndc.value();
    const Vector2d middle = (near[0] + far[2]) / 2;
    EXPECT_TRUE(is_among(middle + ndc.x() * x + ndc.y() * y + ndc.z() * z, points));
  }

  void expect_names_apart() const {
    const AlignedBox2d panel(Vector2d::Zero(), Vector2d(kPanel.width, kPanel.height));
    for (const Drawing& drawing :
         {panel_, image_panel(*report_, kPanel), ndc_panel(*report_, kPanel)}) {
      std::vector<AlignedBox2d> boxes;
      for (const auto& item : drawing.items)
        if (const auto* text = std::get_if<Text>(&item)) {
          const Vector2d half(text_width(*text) / 2, 1.25 * text->size / 2);
          boxes.emplace_back(text->place - half, text->place + half);
        }
      EXPECT_FALSE(boxes.empty());
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_TRUE(panel.contains(boxes[i])) << i;
        for (std::size_t k = 0; k < i; ++k)
          EXPECT_FALSE(boxes[i].intersects(boxes[k])) << i << " " << k;
      }
    }
  }

 private:
  // "TAG:CORNER" or "X,Y,Z".
  NamedPoint point_of(const std::string& at) const {
    Vector3d x;
    CornerId id{};
    if (std::sscanf(at.c_str(), "%lf,%lf,%lf", &x[0], &x[1], &x[2]) == 3) return {at, {}, x, {}};
    EXPECT_EQ(std::sscanf(at.c_str(), "%d:%d", &id.tag_id, &id.corner), 2) << at;
    return named_corner(scene_, id).value();
  }

  MovingScene moving_;
  Scene scene_;
  std::optional<ViewReport> report_;
  std::optional<OutsideView> outside_;
  Drawing panel_;
};

class ViewDrawing : public Cli {};

TEST_F(ViewDrawing, TheDoorwayIsWhereItIs) {
  const Viewed viewed(kDoorway, 0, "1:2", NearFar{1, 10});
  viewed.expect_positions();
  viewed.expect_names_apart();
  const Drawing whole = view_drawing(viewed.report());
  for (const std::string name :
       {"near plane, 1 m", "far plane, 10 m", "world", "camera", "board 1", "board 0", "occluder 0",
        "occluder 3", "stopped by occluder 1", "image point", "tag 1 corner 2", "(-0.5, -0.5)",
        "(639.5, 479.5)", "far, z = 1"})
    EXPECT_TRUE(has_name(whole, name)) << name;
  EXPECT_TRUE(viewed.has_near() && viewed.has_far());
  // The wall is at y = 2, half way to the point.
  EXPECT_LT((viewed.report().followed.hit_in_world.value() - Vector3d(0.9, 2, 1.2)).norm(), 1e-9);
  viewed.expect_axes(Eigen::Affine3d(viewed.report().scene.boards[1].world_from_board.matrix()));
}

TEST_F(ViewDrawing, NearAndFarMoveTheirPlanes) {
  for (const NearFar planes : {NearFar{0.5, 4.5}, {2, 6}, {3, 9}}) {
    SCOPED_TRACE(planes.near_m);
    const Viewed viewed(kDoorway, 0, "0:2", planes);
    EXPECT_TRUE(viewed.has_near() && viewed.has_far());
    viewed.expect_positions();
  }
  const Viewed far(kDoorway, 0, "0:2", NearFar{0.5, 1000});
  EXPECT_TRUE(far.has_near());
  EXPECT_FALSE(far.has_far());
  EXPECT_TRUE(far.panel().has_text("far plane at 1000 m: beyond the drawing"));
  far.expect_positions();
  far.expect_names_apart();
  const Viewed both(kDoorway, 0, "0:2", NearFar{50, 100});
  EXPECT_FALSE(both.has_near());
  EXPECT_TRUE(both.panel().has_text("near plane at 50 m, far plane at 100 m: beyond"));
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
  struct Case {
    const char *file, *at;
    int view = 0;
  };
  for (const auto& [file, at, view] : {Case{"frames.yaml", "0:0", 3},
                                       {"wide.yaml", "0:0"},
                                       {"oblique.yaml", "5:1"},
                                       {"scene.yaml", "0:0", 2},
                                       {"scene.yaml", "0.1,0.1,0.3"},
                                       {"wide.yaml", "0,0,5"}}) {
    SCOPED_TRACE(std::string(file) + " " + at);
    const Viewed viewed(path(file), view, at);
    viewed.expect_positions();
    viewed.expect_names_apart();
    EXPECT_EQ(view_drawing(viewed.report())
                  .has_text("of the pinhole with the same focal length on the axis"),
              std::string(file) == "wide.yaml");
  }
  const Viewed viewed(path("frames.yaml"), 0, "0:0");
  for (const std::string name : {"table", "a<b", "cuboid 0"})
    EXPECT_TRUE(has_name(viewed.panel(), name)) << name;
}

}  // namespace
}  // namespace tagcal::tools
