// What a picture shows and why not more; and one tag fitted by itself.
#include <iostream>
#include <tagcal/detect/detector.hpp>
#include <tagcal/detect/explain.hpp>
#include <tagcal/detect/families.hpp>
#include <tagcal/detect/refine.hpp>
#include <tagcal/io/scene_file.hpp>
#include <tagcal/io/target_file.hpp>
#include <tagcal/scene/render.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  // io/scene_file.hpp, io/target_file.hpp: a recipe; its board as a file to print
  const tagcal::Scene scene = tagcal::read_scene(argv[1]);
  tagcal::write_target("target.yaml", scene.boards[0].board);
  const tagcal::TagFamily family = tagcal::tag_family("tag36h11", 1);
  const tagcal::Image8 image = tagcal::expose(
      tagcal::render_light(scene, {{"tag36h11", family}}, tagcal::camera_poses(scene, 7)[0]),
      scene.sensor, 7);

  // detect/explain.hpp
  const tagcal::Explanation why = tagcal::explain(image, scene.boards);
  std::cout << why.reported.size() << " tags reported, " << why.not_reported.size() << " not\n";
  // detect/refine.hpp: the corners of one tag, from AprilTag's own
  const tagcal::View view =
      tagcal::detect(image, scene.boards, {.refinement = tagcal::Refinement::stock}).view;
  if (view.observations.size() < 4) return 1;
  std::array<Eigen::Vector2d, 4> start;
  for (std::size_t i = 0; i < 4; ++i) start[i] = view.observations[i].pixel;
  const int id = view.observations[0].id.tag_id;
  const tagcal::TagFit fit = tagcal::refine_tag(image, tagcal::tag_pattern(family, id, 1), start);
  if (fit.status != tagcal::TagFitStatus::converged) return 1;
  std::cout << "tag " << id << " corner 0 at " << fit.corners[0].transpose() << ", blur "
            << fit.blur_px << " px\n";
}
