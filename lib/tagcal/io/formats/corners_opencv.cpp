#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/formats/opencv_camera.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

// The sample's board_width and board_height must be those of the target.
void check_board(const YamlValue& top, const std::vector<PlacedBoard>& boards) {
  const auto grid = point_grid(boards[0].board);
  if (!grid) return;
  for (const auto& [key, expected] :
       {std::pair{"board_width", grid->columns}, std::pair{"board_height", grid->rows}}) {
    const auto value = top.find(key);
    if (value && value->whole(1, limits::kMaxSidePx) != expected)
      value->fail(fmt::format("must be {} as in the target", expected));
  }
}

std::string read_name(const YamlValue& value, std::set<std::string>& others) {
  std::string name = read_image_name(value, others);
  if (!is_image_name(name)) value.fail("must be the name of an image");
  return name;
}

std::vector<std::string> read_names(const YamlValue& top, std::size_t count,
                                    std::vector<std::string>* notes) {
  std::vector<std::string> names;
  if (const auto list = top.find("image_names")) {
    std::set<std::string> others;
    if (count == 1 && list->is_scalar()) return {read_name(*list, others)};  // a list of one in XML
    for (const YamlValue& name : list->items(count, count))
      names.push_back(read_name(name, others));
    return names;
  }
  for (std::size_t i = 0; i < count; ++i) names.push_back(view_name(i));
  if (notes)
    notes->push_back(fmt::format("image_points has no names of pictures: they are {} to {}",
                                 names.front(), names.back()));
  return names;
}

// Rows of x, y, .. of the views that have all corners.
struct FullViews {
  std::vector<std::string> names;
  Eigen::MatrixXd pixels;
};

FullViews full_views(const std::vector<View>& views, const std::vector<CornerId>& corners) {
  FullViews full;
  full.pixels.resize(static_cast<Eigen::Index>(views.size()),
                     static_cast<Eigen::Index>(2 * corners.size()));
  for (const View& view : views) {
    std::map<CornerId, Eigen::Vector2d> pixels;
    for (const Observation& o : view.observations) pixels.emplace(o.id, o.pixel);
    if (std::ranges::any_of(corners, [&](const CornerId& id) { return !pixels.contains(id); }))
      continue;
    const auto row = static_cast<Eigen::Index>(full.names.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      full.pixels.block<1, 2>(row, static_cast<Eigen::Index>(2 * i)) =
          pixels.at(corners[i]).transpose();
    full.names.push_back(view.image);
  }
  full.pixels.conservativeResize(static_cast<Eigen::Index>(full.names.size()), Eigen::NoChange);
  return full;
}

}  // namespace

bool is_image_points(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos ||
      (text[first] != '%' && text[first] != '<' && text[first] != '{'))
    return false;
  return text.find("image_points") != std::string_view::npos;
}

std::vector<View> read_image_points(const std::string& text, const std::string& file,
                                    const std::vector<PlacedBoard>& boards,
                                    std::vector<std::string>* notes) {
  const std::vector<CornerId> corners = listed_corners(boards, file);
  const YamlValue top = parse_storage(text, file);
  check_board(top, boards);
  const YamlValue value = top.at("image_points");
  const Eigen::MatrixXd points = read_matrix(value);
  if (points.cols() != static_cast<Eigen::Index>(2 * corners.size()))
    value.fail_plainly(
        fmt::format("must have {} points a row, one per corner of the target, of "
                    "type 2f or 2d, got {}",
                    corners.size(), points.cols() / 2));
  const std::vector<std::string> names =
      read_names(top, static_cast<std::size_t>(points.rows()), notes);
  std::vector<View> views;
  for (Eigen::Index row = 0; row < points.rows(); ++row) {
    View view{names[static_cast<std::size_t>(row)], {}};
    for (std::size_t i = 0; i < corners.size(); ++i) {
      Observation observation;
      observation.id = corners[i];
      observation.pixel = points.block<1, 2>(row, static_cast<Eigen::Index>(2 * i)).transpose();
      view.observations.push_back(observation);
    }
    views.push_back(std::move(view));
  }
  return views;
}

std::string image_points_text(const std::vector<View>& views,
                              const std::vector<PlacedBoard>& boards, std::string_view extension,
                              std::vector<std::string>& notes) {
  const FullViews full = full_views(views, listed_corners(boards, "image_points"));
  if (full.names.empty())
    throw Error("image_points has views with all corners only, and there is none");
  if (full.names.size() < views.size())
    notes.push_back(fmt::format("dropped: {} views in which corners are missing",
                                views.size() - full.names.size()));
  StorageText storage(storage_kind(extension));
  storage.texts("image_names", full.names);
  storage.matrix("image_points", full.pixels, true);
  return storage.text();
}

}  // namespace tagcal::internal
