#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>

#include "report/view_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCircleRadius = 0.1;  // m; of the circle about the point whose image is given

// The image without distortion of the board's plane: (x, y, 1) on the board to pixels.
Matrix3d raster_from_board(const ViewingPipeline& p, const Pose& world_from_board) {
  const Matrix4d all = p.raster_from_ndc * p.clip_from_eye * p.eye_from_camera *
                       (p.camera_from_world * world_from_board).matrix();
  Matrix3d h;
  int row = 0;
  for (const int r : {0, 1, 3}) h.row(row++) << all(r, 0), all(r, 1), all(r, 3);
  return h;
}

// The line of sight of the point's pixel, in world coordinates: one metre of it.
std::optional<Line> line_of_sight(const ViewReport& report) {
  if (!report.followed.pixel) return std::nullopt;
  const auto ray = ray_in_camera(report.pipeline.camera.lens, *report.followed.pixel);
  if (!ray) return std::nullopt;
  const Pose world_from_camera = report.pipeline.camera_from_world.inverse();
  return Line{world_from_camera * ray->origin, world_from_camera * (ray->origin + ray->direction)};
}

Json meeting_json(const ViewReport& report, const Pose& world_from_board) {
  const auto sight = line_of_sight(report);
  if (!sight) return {};
  const Matrix3d axes = world_from_board.rotation_matrix();
  const auto at = meeting(*sight, world_from_board.translation(), axes.col(0), axes.col(1));
  if (!at) return {};
  return {{"eye_m", array(sight->a)},
          {"direction", array(Vector3d(sight->b - sight->a))},
          {"t_m", at->t},
          {"u_m", at->u},
          {"v_m", at->v}};
}

// The part of a line a u + b v + c = 0 in the image. No value if it is at infinity or beside it.
std::optional<Segment2> part_in_image(const Vector3d& line, const ImageSize& size) {
  const Vector2d normal = line.head<2>();
  const double far = 1e3 * (size.width + size.height);  // numeric: any length beyond the image
  if (normal.norm() * far < std::abs(line.z())) return std::nullopt;
  const Vector2d foot = -line.z() / normal.squaredNorm() * normal;
  const Vector2d along = far * Vector2d(-normal.y(), normal.x()).normalized();
  const Window image{-0.5, size.width - 0.5, -0.5, size.height - 0.5};
  return clip_line_liang_barsky(image, {foot - along, foot + along});
}

// The image of the line at infinity of the plane.
Json horizon_json(const Matrix3d& raster_from_plane, const ImageSize& size) {
  Vector3d line = transformed_line(raster_from_plane, Vector3d(0, 0, 1)).normalized();
  const auto part = part_in_image(line, size);
  if (part) line /= line.head<2>().norm();
  return {{"line_abc", array(line)},
          {"in_image_px", part ? Json({array(part->from), array(part->to)}) : Json()}};
}

// The image of a circle about the point: a u^2 + b u v + c v^2 + d u + e v + f = 0.
Json circle_json(const Matrix3d& raster_from_plane, const Vector3d& point) {
  const Vector2d m = point.head<2>();
  const Matrix3d circle =
      conic(1, 0, 1, -2 * m.x(), -2 * m.y(), m.squaredNorm() - kCircleRadius * kCircleRadius);
  Matrix3d image = transformed_conic(raster_from_plane, circle);
  image /= image.topLeftCorner<2, 2>().norm();
  const Eigen::Matrix2d quadratic = image.topLeftCorner<2, 2>();
  const bool ellipse = quadratic.determinant() > 0;
  Json result = {
      {"radius_m", kCircleRadius},
      {"conic_abcdef",
       {image(0, 0), 2 * image(0, 1), image(1, 1), 2 * image(0, 2), 2 * image(1, 2), image(2, 2)}},
      {"kind", ellipse ? "ellipse" : "hyperbola: it reaches behind the camera"}};
  if (ellipse)
    result["centre_px"] = array(Vector2d(-quadratic.inverse() * image.topRightCorner<2, 1>()));
  return result;
}

Json image_of_plane(const ViewReport& report, const Pose& world_from_board) {
  const Matrix3d h = raster_from_board(report.pipeline, world_from_board);
  try {
    return {{"raster_from_board", rows(h)},
            {"horizon", horizon_json(h, report.pipeline.camera.image_size)},
            {"circle", circle_json(h, *report.followed.in_board)}};
  } catch (const Error&) {
    return {{"raster_from_board", rows(h)}, {"seen", "edge-on"}};
  }
}

// The plane z = 0 of a board, its normal out of the front.
Eigen::Vector4d plane_in_world(const Pose& world_from_board) {
  const Matrix3d axes = world_from_board.rotation_matrix();
  const Vector3d origin = world_from_board.translation();
  const Eigen::Vector4d plane =
      join(origin.homogeneous(), Vector3d(origin + axes.col(0)).homogeneous(),
           Vector3d(origin + axes.col(1)).homogeneous());
  return plane.head<3>().dot(axes.col(2)) < 0 ? Eigen::Vector4d(-plane) : plane;
}

// The perspective onto z = 1 m has no inverse, but its cofactors transform planes: every plane
// becomes z = 1 m.
Json flattened_json(const Matrix4d& camera_from_world, const Eigen::Vector4d& plane) {
  const Matrix4d flatten = perspective_from_origin(1);
  const Eigen::Vector4d in_camera = transformed_plane(camera_from_world, plane);
  Json result = {{"plane_in_camera", array(in_camera)},
                 {"cofactors_of_perspective_onto_z_1", rows(cofactor_matrix(flatten))}};
  try {
    result["plane_after_it"] = array(transformed_plane(flatten, in_camera));
  } catch (const Error&) {
    result["plane_after_it"] = "none: the plane contains the eye and becomes a line";
  }
  return result;
}

std::string bits(unsigned code) { return std::bitset<4>(code).to_string(); }

// By region codes, and by the line's parameter: 0 at the point of --at, 1 at that of --to.
Json clipped_to_image(const Vector2d& from, const Vector2d& to) {
  const Window window;
  const Segment2 line{from, to};
  const unsigned a = outcode(window, from), b = outcode(window, to);
  Json result = {{"codes_top_bottom_right_left", bits(a) + " " + bits(b)},
                 {"codes_or", bits(a | b)},
                 {"codes_and", bits(a & b)},
                 {"codes_say", !(a | b)  ? "all inside"
                               : (a & b) ? "all outside, beyond one border"
                                         : "cut at a border, and test again"}};
  const auto part = clip_line_cohen_sutherland(window, line);
  result["by_codes_in_ndc"] = part ? Json({array(part->from), array(part->to)}) : Json();
  const auto range = clip_line_liang_barsky(window, line);
  const double squared = std::max((to - from).squaredNorm(), 1e-300);  // numeric: no line, t = 0
  const auto t = [&](const Vector2d& x) { return (x - from).dot(to - from) / squared; };
  result["by_parameter_t"] = range ? Json::array({t(range->from), t(range->to)}) : Json();
  return result;
}

}  // namespace

Json board_plane_steps(const ViewReport& report) {
  if (!report.point.board) return {};
  const Pose& world_from_board = report.scene.boards[*report.point.board].world_from_board;
  const std::vector<Vector3d> corners = {world_from_board * Vector3d(0, 0, 0),
                                         world_from_board * Vector3d(1, 0, 0),
                                         world_from_board * Vector3d(0, 1, 0)};
  const Eigen::Vector4d plane = plane_in_world(world_from_board);
  const ViewingPipeline& p = report.pipeline;
  const Matrix4d eye_from_world = p.eye_from_camera * p.camera_from_world.matrix();
  const Vector3d eye = p.camera_from_world.inverse().translation();
  Json result = {{"plane_in_world", array(transformed_plane(Matrix4d::Identity(), plane))},
                 {"plane_in_eye", array(transformed_plane(eye_from_world, plane))}};
  if (p.volume.projection == Projection::perspective)
    result["side_seen"] = is_back_face(corners, eye) ? "back" : "front";
  result["flattened"] = flattened_json(p.camera_from_world.matrix(), plane);
  result["line_of_sight"] = meeting_json(report, world_from_board);
  result.update(image_of_plane(report, world_from_board));
  return result;
}

Json line_steps(const ViewReport& report) {
  const FollowedPoint &from = report.followed, &to = report.line_to->followed;
  Json result = {{"from", report.point.name}, {"to", report.line_to->point.name}};
  if (from.in_ndc && to.in_ndc) {
    result["from_in_ndc"] = array(*from.in_ndc);
    result["to_in_ndc"] = array(*to.in_ndc);
    result.update(clipped_to_image(from.in_ndc->head<2>(), to.in_ndc->head<2>()));
  } else {
    result["image"] = "an end is behind the eye: the line is cut in space first";
  }
  const auto inside =
      clip_segment(from.in_eye, to.in_eye, clip_planes(report.pipeline.clip_from_eye));
  result["in_space_by_six_planes_t"] = inside ? Json::array({inside->from, inside->to}) : Json();
  return result;
}

}  // namespace tagcal::tools
