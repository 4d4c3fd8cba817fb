// Detection on pictures of boards: any lens, pose and sensor, then damaged. Most of what fits tags
// and corners to pixels is reached by pictures that show some.
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "fuzz/pictures.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/io/text/tags_csv.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace {

using namespace tagcal;

Lens lens_of(fuzz::Bytes& bytes, const ImageSize& size) {
  const double f = size.width * bytes.number(0.4, 3);
  const Eigen::Vector2d centre = image_centre(size);
  const double k1 = bytes.number(-0.4, 0.4), k2 = bytes.number(-0.2, 0.2);
  switch (bytes.byte() % 3) {
    case 0:
      return pinhole(f, f, centre.x(), centre.y());
    case 1:
      return Perspective({f, f, centre.x(), centre.y(), k1, k2, 0.01, -0.01});
    default:
      return Fisheye({f, f, centre.x(), centre.y(), k1 / 4, k2 / 4, 0, 0});
  }
}

// The board before the camera, as large as `share` of the picture.
Pose pose_of(fuzz::Bytes& bytes, const Board& board, const Camera& camera) {
  const auto points = target_points(board);
  Eigen::AlignedBox3d box;
  for (const TargetPoint& p : points) box.extend(p.position);
  const double extent = box.sizes().maxCoeff(), share = bytes.number(0.2, 1.6);
  const double f = parameters(camera.lens)[0];
  const double distance = extent * f / (share * camera.image_size.width);
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond rotation =
      Eigen::AngleAxisd(bytes.number(-std::numbers::pi, std::numbers::pi),
                        Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(bytes.number(-1.1, 1.1), Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(bytes.number(-1.1, 1.1), Eigen::Vector3d::UnitY()) * facing;
  const Eigen::Vector3d middle(bytes.number(-0.4, 0.4) * extent, bytes.number(-0.4, 0.4) * extent,
                               distance);
  return {rotation, middle - rotation * box.center()};
}

Image8 rendered(fuzz::Bytes& bytes, const Board& board, const Camera& camera) {
  Scene scene;
  scene.camera = camera;
  scene.boards = {{board, Pose()}};
  constexpr double kGammas[] = {1, 1, 0.45, 2.2};
  scene.sensor.exposure = bytes.number(0.1, 1.4);
  scene.sensor.blur_px = bytes.number(0, 2);
  scene.sensor.noise_levels = bytes.number(0, 12);
  scene.sensor.gamma = kGammas[bytes.byte() % 4];
  const TagFamilies families = tag_families(scene.boards);
  const Pose camera_from_world = pose_of(bytes, board, camera);
  return expose(render_light(scene, families, camera_from_world), scene.sensor, bytes.byte());
}

// The same picture among other pixels: its rows do not follow each other.
void check_stride(const Image8& image, const std::vector<PlacedBoard>& boards,
                  const DetectOptions& options, const View& expected) {
  const int stride = image.width() + 7;
  Image8 wide({stride, image.height()}, 77);
  for (int y = 0; y < image.height(); ++y) std::copy_n(image.row(y), image.width(), wide.row(y));
  const View seen =
      detect(ImageView8(wide.pixels().data(), image.size(), stride), boards, options).view;
  fuzz::require(seen.observations.size() == expected.observations.size(),
                "a stride changes nothing");
  for (std::size_t i = 0; i < seen.observations.size(); ++i)
    fuzz::require(seen.observations[i].pixel == expected.observations[i].pixel, "nor a corner");
}

// The corners fitted again under a known lens.
void check_refined(const ImageSource& source, const std::vector<PlacedBoard>& boards,
                   const View& view, const Camera& camera) {
  const Dataset dataset{camera.image_size, boards, {view}, {}};
  const View refined = refine_views(dataset, {source}, camera, 1).views.at(0);
  fuzz::require(refined.observations.size() == view.observations.size(), "no corner is lost");
  fuzz::check_view(refined, camera.image_size);
}

void check_all_tags(const ImageSource& source, const TagKind& kind, const DetectOptions& options) {
  const std::vector<PictureTags> found = detect_all_tags({source}, kind, options);
  for (const DetectedTag& tag : found.at(0).tags)
    for (const Eigen::Vector2d& corner : tag.corners)
      fuzz::require(corner.allFinite(), "corners are finite");
  internal::tags_csv({source.name}, {found.at(0).tags});
}

// Changes a box of the picture in one of several ways.
void damage(fuzz::Bytes& bytes, Image8& image) {
  const int left = bytes.whole(0, image.width() - 1), top = bytes.whole(0, image.height() - 1);
  const int right = std::min(image.width(), left + 1 + bytes.byte());
  const int bottom = std::min(image.height(), top + 1 + bytes.byte());
  const int kind = bytes.byte() % 6, value = bytes.byte();
  Random random(static_cast<std::uint64_t>(value));
  const Image8 before = image;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const int level = before(x, y);
      int next = value;                                               // painted over
      if (kind == 1) next = 255 - level;                              // inverted
      if (kind == 2) next = before((x + value) % image.width(), y);   // moved
      if (kind == 3) next = level + (x - left) * (value - 128) / 64;  // light that changes
      if (kind == 4) next = 128 + (level - 128) * value / 128;        // contrast
      if (kind == 5) next = level + static_cast<int>(random.uniform(-value, value));  // noise
      image(x, y) = static_cast<std::uint8_t>(std::clamp(next, 0, 255));
    }
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const ImageSize image_size{bytes.whole(24, 240), bytes.whole(24, 200)};
  const int kind = bytes.byte() % 5;
  const Board board = fuzz::board_of(kind);
  DetectOptions options;
  options.threads = 1;
  options.max_hamming = bytes.byte() % 3;
  constexpr Refinement kRefinements[] = {Refinement::fit, Refinement::fit, Refinement::edges,
                                         Refinement::stock};
  options.refinement = kRefinements[bytes.byte() % 4];
  const bool is_camera_known = bytes.flag(), is_camera_right = bytes.flag();
  const Camera camera{lens_of(bytes, image_size), image_size};
  const Camera other{is_camera_right ? camera.lens : lens_of(bytes, image_size), image_size};
  if (is_camera_known) options.camera = &other;

  Image8 image;
  const bool is_rendered = fuzz::is_accepted([&] { image = rendered(bytes, board, camera); });
  fuzz::require(is_rendered, "every scene can be rendered");
  for (int i = bytes.byte() % 4; i > 0; --i) damage(bytes, image);
  std::vector<PlacedBoard> boards{{board, Pose()}};
  const int more = bytes.byte() % 16;  // what takes long is done at times
  // Beside the board another one, or the same one as it would be with another border.
  if (more == 6 && kind != 1) boards.push_back({fuzz::board_of(1), Pose()});
  if (more == 7 && kind < 2) {
    int& border_bits = std::get<AprilGrid>(boards.front().board.pattern).border_bits;
    border_bits = 3 - border_bits;
  }
  const bool is_searched = fuzz::is_accepted([&] {
    const ImageSource source{"picture", [&] { return image; }};
    const View view = detect_all({source}, boards, options).at(0).view;
    fuzz::check_view(view, image_size);
    if (more == 1) explain(image, boards);
    if (more == 2) check_all_tags(source, tag_kind(board).value_or(TagKind{}), options);
    if (more == 3) check_stride(image, boards, options, view);
    if (more == 4 || more == 5) check_refined(source, boards, view, other);
  });
  fuzz::require(is_searched, "every picture can be searched");
  return 0;
}
