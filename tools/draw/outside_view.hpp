#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "draw/view_panels.hpp"
#include "tagcal/camera/camera.hpp"

namespace tagcal::tools {

struct DrawnFrame {
  std::string name;
  Affine world_from_frame;
};

// What the drawing of a scene from outside shows, in world coordinates, and the camera that draws
// it.
class OutsideView {
 public:
  explicit OutsideView(const ViewReport& report);

  Eigen::Vector3d in_world(const Eigen::Vector3d& x_in_eye) const {
    return (world_from_eye_ * x_in_eye.homogeneous()).head<3>();
  }

  // Where the line of sight starts: the eye, or the point's foot in the plane of parallel rays.
  Eigen::Vector3d sight_start_in_eye() const;

  // The four corners of the view volume's cross-section, or of its extension.
  std::vector<Eigen::Vector3d> cross_section(double depth_m) const;

  // The depth up to which the volume is drawn: far, or less if its corners would be far away.
  double drawn_depth_m() const { return drawn_depth_m_; }

  // The depth of the drawn image plane: any gives the same image. Between near and the point, or
  // where the volume is cut.
  double image_depth_m() const;

  // World, camera, the board of the point and the scene's frames, without those far away.
  const std::vector<DrawnFrame>& frames() const { return frames_; }
  const std::string& left_out() const { return left_out_; }  // the names of those
  Eigen::Vector3d axis_tip(const DrawnFrame& frame, int axis) const;

  // A pinhole that looks across the line of sight, from above and a little behind, and shows all
  // of it as large as the panel allows.
  Pose camera_from_world() const;
  Camera camera(const PanelSize& size) const;

 private:
  Eigen::AlignedBox3d scene_box() const;
  bool is_near(const Eigen::Vector3d& x, double reach) const;
  double find_drawn_depth_m() const;
  void find_frames();
  std::vector<Eigen::Vector3d> points() const;

  const ViewReport& report_;
  Eigen::Matrix4d world_from_eye_;
  Eigen::AlignedBox3d scene_box_;  // of camera, objects and point
  double drawn_depth_m_;
  std::vector<DrawnFrame> frames_;
  std::string left_out_;
};

}  // namespace tagcal::tools
