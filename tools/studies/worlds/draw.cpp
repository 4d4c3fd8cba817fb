#include "draw.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "tagcal/internal/degrees.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using internal::kDegree;
constexpr std::size_t kFewestCorners = 8;  // visible in a view
constexpr int kMostTries = 30;             // to draw a view with kFewestCorners
constexpr std::uint64_t kLightStream = 2001, kPictureStream = 2002;

// Distribution of the views of a world.
struct ViewSpread {
  double tag_px = 0;
  double size_factor = 1;  // of the tag's side in the image, largest over typical
  double place = 0;        // of the board's centre: 0 the image's centre, 1 anywhere in the image
  double most_tilt_rad = 0;
  double most_roll_rad = 0;
};

// Pixels per radian about a ray of the lens: the root of the area in the image per solid angle.
std::optional<double> pixels_per_radian(const Lens& lens, const Vector3d& direction) {
  constexpr double kStep = 1e-4;
  const Vector3d across = direction.unitOrthogonal(), down = direction.cross(across);
  const auto p = project(lens, direction);
  const auto q = project(lens, direction + kStep * across);
  const auto r = project(lens, direction + kStep * down);
  if (!p || !q || !r) return std::nullopt;
  const Vector2d u = (*q - *p) / kStep, v = (*r - *p) / kStep;
  return std::sqrt(std::abs(u.x() * v.y() - u.y() * v.x()));
}

const AprilGrid& grid_of(const Scene& scene) {
  return std::get<AprilGrid>(scene.boards[0].board.pattern);
}

Vector3d board_centre(const AprilGrid& grid) {
  const double pitch = grid.tag_size * (1 + grid.tag_spacing), gap = pitch - grid.tag_size;
  return {(grid.columns * pitch - gap) / 2, (grid.rows * pitch - gap) / 2, 0};
}

std::optional<Pose> draw_pose(const Camera& camera, const AprilGrid& grid, const ViewSpread& spread,
                              Random& random) {
  const double dx = random.uniform(-0.5, 0.5), dy = random.uniform(-0.5, 0.5);
  const Vector2d pixel =
      image_centre(camera.image_size) +
      spread.place * Vector2d(dx * camera.image_size.width, dy * camera.image_size.height);
  const double log_factor = std::log(spread.size_factor);
  const double tag_px = spread.tag_px * std::exp(random.uniform(-log_factor, log_factor));
  const double tilt = spread.most_tilt_rad * random.uniform();
  const double side = random.uniform(0, 2 * std::numbers::pi);
  const double roll = random.uniform(-spread.most_roll_rad, spread.most_roll_rad);
  const auto ray = ray_in_camera(camera.lens, pixel);
  const auto scale = ray ? pixels_per_radian(camera.lens, ray->direction) : std::nullopt;
  if (!scale) return std::nullopt;
  const double distance = grid.tag_size * *scale / tag_px;

  const Vector3d towards_eye = -ray->direction;
  const Vector3d axis = Eigen::AngleAxisd(side, towards_eye) * towards_eye.unitOrthogonal();
  const Vector3d normal = Eigen::AngleAxisd(tilt, axis) * towards_eye;
  Vector3d right = Vector3d::UnitX() - normal.x() * normal;
  right = Eigen::AngleAxisd(roll, normal) * right.normalized();
  Eigen::Matrix3d axes;
  axes << right, normal.cross(right), normal;
  const Eigen::Quaterniond rotation(axes);
  return Pose(rotation, distance * ray->direction - rotation * board_centre(grid));
}

// No value if the board would have too few or too many tags, or tags that do not fit into the
// image.
std::optional<AprilGrid> draw_board(World& world, Random& random) {
  const ImageSize& size = world.scene.camera.image_size;
  const double tag_px = log_uniform(12, 300, random);
  const double wanted = log_uniform(0.04, 1, random);
  const bool kalibr = random.uniform() < 0.5;
  const double spacing = kalibr ? random.uniform(0.2, 0.4) : random.uniform(0.15, 0.5);
  const double pitch_px = tag_px * (1 + spacing);
  const double area = static_cast<double>(size.width) * size.height;
  const double count = wanted * area / (pitch_px * pitch_px);
  if (count < 3 || count > 64 || pitch_px > size.height) return std::nullopt;
  const double aspect = log_uniform(0.7, 1.8, random);
  const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(count * aspect))));
  const int rows = std::max(1, static_cast<int>(std::lround(count / columns)));
  if (columns * rows < 3) return std::nullopt;
  world.tag_px = tag_px;
  world.coverage = columns * rows * pitch_px * pitch_px / area;
  const double tag_size = log_uniform(0.02, 0.2, random);
  return AprilGrid{columns, rows, tag_size, spacing, 0, "tag36h11", kalibr ? 2 : 1, kalibr};
}

ViewSpread draw_spread(const World& world, Random& random) {
  ViewSpread spread;
  spread.tag_px = world.tag_px;
  spread.size_factor = log_uniform(1.02, 1.8, random);
  spread.place = random.uniform();
  spread.most_tilt_rad = kDegree * world.most_tilt_deg;
  constexpr double kRolls[] = {5, 30, 180};
  spread.most_roll_rad = kDegree * kRolls[random.index(std::size(kRolls))];
  return spread;
}

bool draw_views(Scene& scene, const ViewSpread& spread, Random& random) {
  ExplicitPath path;
  const AprilGrid& grid = grid_of(scene);
  for (int view = 0; view < scene.num_views; ++view) {
    bool found = false;
    for (int i = 0; i < kMostTries && !found; ++i) {
      const auto pose = draw_pose(scene.camera, grid, spread, random);
      found = pose && visible_corners(scene, *pose).size() >= kFewestCorners;
      if (found) path.camera_from_world.push_back(*pose);
    }
    if (!found) return false;
  }
  scene.path = path;
  return true;
}

// Half of the sensors are linear; 60 % of the prints are as designed. Levels keep a distance from
// black and white, so that noise is not clipped.
void draw_sensor(World& world, Random& random) {
  Scene& scene = world.scene;
  scene.sensor.blur_px = log_uniform(0.3, 2, random);
  scene.sensor.noise_levels = log_uniform(0.3, 8, random);
  const double background = random.uniform(0.1, 0.8), paper = random.uniform(0.55, 0.88),
               ink = random.uniform(0.1, 0.25);  // in the picture
  if (random.uniform() < 0.5) scene.sensor.gamma = random.uniform(0.45, 1);
  const double power = 1 / scene.sensor.gamma;
  scene.background_level = std::pow(background, power);
  scene.paper_level = std::pow(paper, power);
  scene.ink_level = std::pow(ink, power);
  if (random.uniform() < 0.4) world.ink_spread_px = random.uniform(-0.05, 0.15);
  scene.ink_spread_m = world.ink_spread_px * grid_of(scene).tag_size / world.tag_px;
}

// A lamp that lights the nearest part of the board fully and the others less, and a lens that loses
// 5 % (a small aperture) to 50 % (a wide lens, wide open) of the light in the image's corners.
void draw_light(World& world) {
  if (!world.defects.uneven_light) return;
  Random random = stream_of(world.id, kLightStream);
  Scene& scene = world.scene;
  scene.sensor.vignetting.polynomial = {-random.uniform(0.05, 0.5)};
  const Vector3d centre = board_centre(grid_of(scene));
  const double diagonal = 2 * centre.norm(), height = diagonal * log_uniform(0.5, 3, random);
  const double x = diagonal * random.uniform(-1, 1), y = diagonal * random.uniform(-1, 1);
  Light light;
  light.ambient = random.uniform(0.3, 0.7);
  light.lamp = PointLamp{centre + Vector3d(x, y, height), (1 - light.ambient) * height * height};
  scene.light = light;
}

// What the renderer has on flat boards only: Kalibr's squares between the tags, and occluders just
// behind the paper.
void adapt_to_bend(World& world) {
  if (world.id.mode != kPixels || !world.defects.of_board()) return;
  std::get<AprilGrid>(world.scene.boards[0].board.pattern).corner_squares = false;
  world.scene.occluders.clear();
}

void keep_few_views(World& world) {
  Scene& scene = world.scene;
  if (world.defects.most_views == 0) return;
  scene.num_views = std::min(scene.num_views, world.defects.most_views);
  auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
  poses.resize(static_cast<std::size_t>(scene.num_views));
}

using Polygon = std::vector<Vector2d>;

// True if all of `b` lies beyond one side of `a` (both convex, any orientation).
bool has_separating_side(const Polygon& a, const Polygon& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector2d side = a[(i + 1) % a.size()] - a[i];
    const Vector2d normal(-side.y(), side.x());
    double a_low = 0, a_high = 0, b_low = HUGE_VAL, b_high = -HUGE_VAL;
    for (const Vector2d& p : a) {
      a_low = std::min(a_low, normal.dot(p - a[i]));
      a_high = std::max(a_high, normal.dot(p - a[i]));
    }
    for (const Vector2d& p : b) {
      b_low = std::min(b_low, normal.dot(p - a[i]));
      b_high = std::max(b_high, normal.dot(p - a[i]));
    }
    if (b_low > a_high || b_high < a_low) return true;
  }
  return false;
}

// True if the occluder may hide a part of the paper, in the plane z = 0, from an eye above it.
bool cuts(const Occluder& occluder, const Polygon& paper, const Vector3d& eye) {
  Polygon shadow;
  for (const Vector3d& p : occluder.corners) {
    if (p.z() > 0.8 * eye.z()) return true;  // beside the eye or behind it
    const Vector3d x = eye + (p - eye) * eye.z() / (eye.z() - p.z());
    shadow.push_back(x.head<2>());
  }
  return !has_separating_side(shadow, paper) && !has_separating_side(paper, shadow);
}

Occluder draw_polygon(const Vector3d& centre, double radius_m, Random& random) {
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond{random.normal(), random.normal(), random.normal(), random.normal()}
          .normalized();  // braces: evaluated in this order
  Occluder occluder;
  occluder.level = random.uniform();
  const int count = 3 + static_cast<int>(random.index(4));
  const double start = random.uniform(0, 2 * std::numbers::pi), squeeze = random.uniform(0.3, 1);
  for (int i = 0; i < count; ++i) {
    const double angle = start + 2 * std::numbers::pi * i / count;
    occluder.corners.emplace_back(
        centre + turn * (radius_m * Vector3d(std::cos(angle), squeeze * std::sin(angle), 0)));
  }
  return occluder;
}

// Convex polygons beside and behind the board that hide no part of its paper in any view.
std::vector<Occluder> draw_occluders(const Scene& scene, Random& random) {
  const Rectangle paper = board_panels(scene.boards[0].board, scene.paper_margin_m)[0].paper;
  Polygon outline;
  for (const Vector3d& p : paper) outline.push_back(p.head<2>());
  const Vector3d middle = (paper[0] + paper[2]) / 2;
  const double diagonal = (paper[2] - paper[0]).norm();
  std::vector<Occluder> occluders;
  const std::size_t count = 1 + random.index(4);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const double away = diagonal * random.uniform(0, 1.2);
    const Vector3d centre = middle + Vector3d(away * std::cos(angle), away * std::sin(angle),
                                              diagonal * random.uniform(-0.4, 0.15));
    const Occluder occluder = draw_polygon(centre, diagonal * random.uniform(0.05, 0.5), random);
    const bool behind = std::ranges::all_of(
        occluder.corners, [&](const Vector3d& p) { return p.z() < -1e-3 * diagonal; });
    const auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
    const bool harmless = behind || std::ranges::none_of(poses, [&](const Pose& pose) {
                            return cuts(occluder, outline, pose.inverse().translation());
                          });
    if (harmless) occluders.push_back(occluder);
  }
  return occluders;
}

}  // namespace

World draw_world(const WorldId& id) {
  Random random(id.seed, id.index);
  const Defects defects = draw_defects(id);
  while (true) {
    World world{id, {}, defects};
    Scene& scene = world.scene;
    DrawnCamera drawn = draw_camera(random);
    scene.camera = drawn.camera;
    scene.model = drawn.model;
    world.field_of_view_deg = drawn.field_of_view_deg;
    std::optional<AprilGrid> board;
    while (!board) board = draw_board(world, random);
    scene.boards = {{make_board(*board), Pose()}};
    scene.paper_margin_m = board->tag_size * random.uniform(0.15, 1);
    // 2 to 41, a quarter of them below 6; with the worlds of few views half are.
    scene.num_views = static_cast<int>(2 * std::pow(20.99, std::pow(random.uniform(), 0.735)));
    world.most_tilt_deg = random.uniform(3, 65);
    if (!draw_views(scene, draw_spread(world, random), random)) continue;
    if (random.uniform() < 0.3) scene.occluders = draw_occluders(scene, random);
    draw_sensor(world, random);
    draw_light(world);
    adapt_to_bend(world);
    keep_few_views(world);
    if (!defects.camera) return world;
    Random of_pictures = stream_of(id, kPictureStream);
    world.pictures = draw_pictures(fixed_pictures(id), scene, of_pictures);
    return world;
  }
}

}  // namespace tagcal
