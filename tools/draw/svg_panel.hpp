#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/scene.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {

inline constexpr std::string_view kInk = "#222";
inline constexpr std::string_view kVolumeColour = "#2a78b8";
inline constexpr std::string_view kPlaneColour = "#7b2d8e";  // of the image plane
inline constexpr std::string_view kPointColour = "#d9480f";
inline constexpr std::string_view kAxisColours[3] = {"#c92a2a", "#2b8a3e", "#1c4fd8"};

std::string grey(double level);

// Points "x,y x,y" of an SVG element, and elements with a name (`id`) and a style.
std::string svg_points(const std::vector<Eigen::Vector2d>& points);
std::string svg_polygon(std::string_view id, const std::vector<Eigen::Vector2d>& points,
                        std::string_view style);
std::string svg_line(std::string_view id, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     std::string_view style);
std::string svg_circle(std::string_view id, const Eigen::Vector2d& centre, double radius,
                       std::string_view style);

// Draws a scene in SVG through a camera, by the library's own projection.
class SvgPanel {
 public:
  SvgPanel(Camera camera, const Pose& camera_from_world)
      : camera_(std::move(camera)), camera_from_world_(camera_from_world) {}

  const Camera& camera() const { return camera_; }
  const Pose& camera_from_world() const { return camera_from_world_; }

  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector3d& x_in_world) const {
    return project(camera_.lens, camera_from_world_ * x_in_world);
  }

  // What is seen of papers, tags and occluders, then of their edges, then the targets' points.
  std::string things(const Scene& scene) const;

 private:
  std::string outline(const std::vector<Eigen::Vector3d>& corners, std::string_view style) const;
  std::string segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;
  std::string visible_area(const std::vector<Eigen::Vector3d>& corners, const Shadows& shadows,
                           std::size_t sheet, std::string_view colour) const;
  std::string visible_edges(const std::vector<Eigen::Vector3d>& corners, const Shadows& shadows,
                            std::size_t sheet) const;
  void append(const Eigen::Vector3d& a, const Eigen::Vector3d& b, int num_points,
              std::vector<Eigen::Vector2d>& pixels) const;

  Camera camera_;
  Pose camera_from_world_;
};

// Places names beside points of a picture, so that no name covers another one or a marked point:
// each at the nearest free place around its point, with a line to it if that is not beside it. A
// name without a free place is left out.
class SvgLabels {
 public:
  explicit SvgLabels(const Window& area) : area_(area) {}

  double height() const { return area_.top; }

  void keep_free(const Eigen::Vector2d& point);
  void add(std::string_view text, const Eigen::Vector2d& point, std::string_view colour);

  // Places all names, those that were added first at the best places.
  std::string svg();

 private:
  struct Name {
    std::string text;
    Eigen::Vector2d point;
    std::string_view colour;
  };

  void place(const Name& name);
  bool is_free(const Window& box, const Segment2& leader) const;
  void draw(const Name& name, const Window& box, const Segment2& leader);

  Window area_;
  std::vector<Name> names_;
  std::vector<Window> taken_;
  std::vector<Segment2> leaders_;
  std::string svg_;
};

}  // namespace tagcal::tools
