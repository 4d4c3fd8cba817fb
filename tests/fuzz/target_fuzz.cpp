// Target files: what was read is written and read again.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/target_file.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tagcal;
  static const fuzz::Scratch scratch;
  const std::filesystem::path file = scratch.write("target.yaml", fuzz::text_of(data, size));
  fuzz::is_accepted([&] {
    const Board numbered = read_target(file, 1000);
    for (const TargetPoint& point : target_points(numbered))
      fuzz::require(point.id.tag_id >= 1000, "the first id is that asked for");
  });
  fuzz::is_accepted([&] { read_target(file, {}, nullptr, 0.2); });
  fuzz::is_accepted([&] {
    const Board board = read_target(file);
    const std::vector<TargetPoint> points = target_points(board);
    if (points.size() > 1000) return;  // large boards take long, and are like others
    for (const TargetPoint& point : points)
      fuzz::require(point.position.allFinite(), "points are finite");

    const std::filesystem::path copy = scratch.folder() / "copy.yaml";
    bool is_same = false;
    const bool is_read = fuzz::is_accepted([&] {
      write_target(copy, board);
      const std::vector<TargetPoint> again = target_points(read_target(copy));
      is_same = points.size() == again.size();
      for (std::size_t i = 0; is_same && i < points.size(); ++i) {
        const double length = points[i].position.norm() + 1e-300;
        is_same = points[i].id == again[i].id &&
                  (points[i].position - again[i].position).norm() <= 1e-9 * length;
      }
    });
    fuzz::require(is_read, "a target that was read can be written and read again");
    fuzz::require(is_same, "and is the same");
  });
  return 0;
}
