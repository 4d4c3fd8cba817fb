#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/plot/drawing.hpp"
#include "tagcal/scene/scene.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {

inline constexpr std::string_view kInk = "#222222";
inline constexpr std::string_view kVolumeColour = "#2a78b8";
inline constexpr std::string_view kPlaneColour = "#7b2d8e";  // of the image plane
inline constexpr std::string_view kPointColour = "#d9480f";
inline constexpr std::string_view kAxisColours[3] = {"#c92a2a", "#2b8a3e", "#1c4fd8"};

std::string grey_colour(double level);  // of black 0 and white 1

// A filled shape, and the line around one.
void add_area(const std::vector<Eigen::Vector2d>& points, std::string_view colour, double opacity,
              study::Drawing& drawing);
void add_outline(std::vector<Eigen::Vector2d> points, std::string_view colour, double width,
                 study::Drawing& drawing);
void add_disc(const Eigen::Vector2d& centre, double radius, std::string_view colour,
              study::Drawing& drawing);
void add_ring(const Eigen::Vector2d& centre, double radius, std::string_view colour,
              study::Drawing& drawing);

// Draws a scene through a camera, by the library's own projection, cut at the borders of the image.
class ScenePen {
 public:
  ScenePen(Camera camera, const Pose& camera_from_world)
      : camera_(std::move(camera)), camera_from_world_(camera_from_world) {}

  const Camera& camera() const { return camera_; }

  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector3d& x_in_world) const {
    return project(camera_.lens, camera_from_world_ * x_in_world);
  }

  // Draws the visible parts of papers, tags and occluders, then their visible edges, then measured
  // points.
  void draw(const Scene& scene, study::Drawing& drawing) const;

 private:
  void draw_outline(const std::vector<Eigen::Vector3d>& corners, std::string_view colour,
                    study::Drawing& drawing) const;
  void draw_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    study::Drawing& drawing) const;
  void draw_visible_area(const std::vector<Eigen::Vector3d>& corners, const Shadows& shadows,
                         std::size_t sheet, std::string_view colour, study::Drawing& drawing) const;
  void draw_visible_edges(const std::vector<Eigen::Vector3d>& corners, const Shadows& shadows,
                          std::size_t sheet, study::Drawing& drawing) const;
  void append(const Eigen::Vector3d& a, const Eigen::Vector3d& b, int num_points,
              std::vector<Eigen::Vector2d>& pixels) const;

  Camera camera_;
  Pose camera_from_world_;
};

}  // namespace tagcal::tools
