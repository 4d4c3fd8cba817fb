#include "tagcal/io/yaml/yaml_boards.hpp"

#include <fmt/format.h>

#include <limits>
#include <set>

#include "tagcal/internal/text.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

constexpr const char* kTypes =
    "must be aprilgrid, tags, checkerboard, charuco, circlegrid or points";
constexpr int kMaxId = std::numeric_limits<int>::max();

// Reads the keys that all kinds of tags have; their defaults are those of the kind.
template <typename Kind>
void read_print(const YamlValue& top, Kind& kind) {
  if (const auto family = top.find("family")) kind.family = family->text();
  if (const auto bits = top.find("border_bits")) kind.border_bits = bits->whole(1, 2);
}

Tolerance read_tolerance(const YamlValue& top, const char* key) {
  const auto value = top.find(key);
  if (!value) return Material::paper;
  if (value->is_number()) {
    const double share = value->number();
    if (share > 0 && share <= kMaxTolerance) return share;
  } else if (value->is_scalar()) {
    if (const auto material = material_named(value->text())) return *material;
  }
  value->fail(
      fmt::format("must be paper, aluminium, glass or a share > 0 and at most {}", kMaxTolerance));
}

void check_last_id(const YamlValue& where, std::int64_t last_id, const char* key = "first_id") {
  if (last_id <= kMaxId) return;
  where.fail_plainly(fmt::format("{}: the ids must stay below 2^31, but end at {}", key, last_id));
}

// Numbers of tags, corners or squares in both directions.
std::pair<int, int> read_counts(const YamlValue& top, const char* columns_key, const char* rows_key,
                                int least) {
  const int columns = top.at(columns_key).whole(least, kMaxBoardParts);
  const int rows = top.at(rows_key).whole(least, kMaxBoardParts);
  const std::int64_t num_points = std::int64_t{columns} * rows;
  if (num_points > kMaxBoardParts) {
    top.fail_plainly(fmt::format("{} * {}: must be at most {}, got {}", columns_key, rows_key,
                                 kMaxBoardParts, num_points));
  }
  return {columns, rows};
}

int read_first_id(const YamlValue& top, const char* key, std::int64_t num_ids,
                  std::optional<int> instead = {}) {
  const auto in_file = top.find(key);
  int first_id = in_file ? in_file->whole(0, kMaxId) : 0;
  if (instead) first_id = *instead;
  check_last_id(top, first_id + num_ids - 1, key);
  return first_id;
}

double read_spacing(const YamlValue& spacing, double tag_size) {
  const auto gap = spacing.is_number() ? std::nullopt : parse_length(spacing.text());
  if (gap && *gap >= 0)
    spacing.fail(fmt::format("must be the gap divided by tagSize, {:.3g}", *gap / tag_size));
  return spacing.not_negative();
}

BoardPattern read_grid(const YamlValue& top, std::optional<int> first_id,
                       std::vector<std::string>* warnings) {
  const std::vector<std::string> unknown =
      top.unknown_keys({"target_type", "tagCols", "tagRows", "tagSize", "tagSpacing", "first_id",
                        "family", "border_bits", "corner_squares", "flatness", "print"});
  const auto [columns, rows] = read_counts(top, "tagCols", "tagRows", 1);
  AprilGrid grid{columns, rows, top.at("tagSize").length()};
  grid.tag_spacing = read_spacing(top.at("tagSpacing"), grid.tag_size);
  grid.first_id = read_first_id(top, "first_id", std::int64_t{columns} * rows, first_id);
  read_print(top, grid);
  const auto squares = top.find("corner_squares");
  grid.corner_squares = squares ? squares->truth() : grid.border_bits == 2;
  if (warnings) warnings->insert(warnings->end(), unknown.begin(), unknown.end());
  return grid;
}

// Number to add to each id so that the smallest one becomes first_id.
std::int64_t id_shift(const YamlValue& top, const std::set<int>& ids, std::optional<int> first_id) {
  const auto in_file = top.find("first_id");
  if (in_file && !first_id) first_id = in_file->whole(0, kMaxId);
  if (!first_id) return 0;
  const std::int64_t shift = std::int64_t{*first_id} - *ids.begin();
  check_last_id(top, *ids.rbegin() + shift);
  return shift;
}

int read_new_id(const YamlValue& value, std::set<int>& ids) {
  const int id = value.whole(0, kMaxId);
  if (!ids.insert(id).second) value.fail("must differ from the ids before it");
  return id;
}

BoardPattern read_tags(const YamlValue& top, std::optional<int> first_id) {
  top.allow_only({"target_type", "tags", "first_id", "family", "border_bits", "corner_squares",
                  "flatness", "print"});
  Tags board;
  read_print(top, board);
  if (const auto squares = top.find("corner_squares"); squares && squares->truth())
    squares->fail("must be false for target_type tags");
  std::set<int> ids;
  const std::vector<YamlValue> items = top.at("tags").items(1, kMaxBoardParts);
  for (const YamlValue& item : items) {
    item.allow_only({"id", "size", "pose"});
    Tag tag;
    tag.id = read_new_id(item.at("id"), ids);
    tag.size = item.at("size").length();
    const auto pose = item.find("pose");
    if (!pose && items.size() > 1) item.at("pose");  // optional for a single tag only
    if (pose) tag.board_from_tag = read_pose(*pose);
    board.tags.push_back(tag);
  }
  const std::int64_t shift = id_shift(top, ids, first_id);
  for (Tag& tag : board.tags) tag.id = static_cast<int>(tag.id + shift);
  return board;
}

TargetPoint read_point(const YamlValue& value, std::set<int>& ids) {
  TargetPoint point;
  if (value.is_list()) {
    const std::vector<YamlValue> items = value.items(4, 4);
    point.id.tag_id = read_new_id(items[0], ids);
    point.position = {items[1].number(), items[2].number(), items[3].number()};
  } else {
    value.allow_only({"id", "x", "y", "z"});
    point.id.tag_id = read_new_id(value.at("id"), ids);
    point.position = {value.at("x").number(), value.at("y").number(), value.at("z").number()};
  }
  return point;
}

BoardPattern read_points(const YamlValue& top, std::optional<int> first_id) {
  top.allow_only({"target_type", "points", "first_id", "flatness", "print"});
  Points board;
  std::set<int> ids;
  for (const YamlValue& item : top.at("points").items(1, kMaxBoardParts))
    board.points.push_back(read_point(item, ids));
  const std::int64_t shift = id_shift(top, ids, first_id);
  for (TargetPoint& point : board.points)
    point.id.tag_id = static_cast<int>(point.id.tag_id + shift);
  return board;
}

BoardPattern read_checkerboard(const YamlValue& top, std::optional<int> first_id,
                               std::vector<std::string>* warnings) {
  const std::vector<std::string> unknown =
      top.unknown_keys({"target_type", "targetCols", "targetRows", "rowSpacingMeters",
                        "colSpacingMeters", "first_id", "starts_black", "flatness", "print"});
  const auto [columns, rows] = read_counts(top, "targetCols", "targetRows", 2);
  Checkerboard board{columns, rows, top.at("colSpacingMeters").length(),
                     top.at("rowSpacingMeters").length()};
  if (const auto black = top.find("starts_black")) board.starts_black = black->truth();
  board.first_id = read_first_id(top, "first_id", std::int64_t{columns} * rows, first_id);
  if (warnings) warnings->insert(warnings->end(), unknown.begin(), unknown.end());
  return board;
}

BoardPattern read_charuco(const YamlValue& top, std::optional<int> first_id) {
  top.allow_only({"target_type", "squareCols", "squareRows", "squareSize", "markerSize",
                  "dictionary", "legacy", "first_id", "first_marker_id", "flatness", "print"});
  const auto [columns, rows] = read_counts(top, "squareCols", "squareRows", 3);
  Charuco board{columns, rows, top.at("squareSize").length()};
  const YamlValue marker_size = top.at("markerSize");
  board.marker_size = marker_size.length();
  if (board.marker_size >= board.square_size)
    marker_size.fail(fmt::format("must be less than squareSize {}", board.square_size));
  board.dictionary = top.at("dictionary").text();
  if (const auto legacy = top.find("legacy")) board.legacy = legacy->truth();
  const std::int64_t num_corners = std::int64_t{columns - 1} * (rows - 1);
  board.first_id = read_first_id(top, "first_id", num_corners, first_id);
  const std::int64_t num_squares = std::int64_t{columns} * rows;
  board.first_marker_id = read_first_id(top, "first_marker_id", (num_squares + 1) / 2);
  return board;
}

// Diameter of a disc whose file does not state it, in spacings. Source: OpenCV's gen_pattern.py
// (radius_rate 5).
constexpr double kDiscShare = 0.4;

BoardPattern read_circles(const YamlValue& top, std::optional<int> first_id,
                          std::vector<std::string>* warnings) {
  const std::vector<std::string> unknown =
      top.unknown_keys({"target_type", "targetCols", "targetRows", "spacingMeters",
                        "asymmetricGrid", "diameterMeters", "first_id", "flatness", "print"});
  const auto [columns, rows] = read_counts(top, "targetCols", "targetRows", 2);
  CircleGrid grid{columns, rows, top.at("spacingMeters").length()};
  if (const auto asymmetric = top.find("asymmetricGrid")) grid.asymmetric = asymmetric->truth();
  grid.diameter = kDiscShare * grid.spacing;
  if (const auto diameter = top.find("diameterMeters")) {
    grid.diameter = diameter->length();
    if (grid.diameter >= centre_distance(grid))
      diameter->fail(
          fmt::format("must be less than {:.6g}, the distance of centres", centre_distance(grid)));
  }
  grid.first_id = read_first_id(top, "first_id", std::int64_t{columns} * rows, first_id);
  if (warnings) warnings->insert(warnings->end(), unknown.begin(), unknown.end());
  return grid;
}

BoardPattern read_kind(const YamlValue& type, const YamlValue& top, std::optional<int> first_id,
                       std::vector<std::string>* warnings) {
  const std::string name = type.text();
  if (name == "aprilgrid") return read_grid(top, first_id, warnings);
  if (name == "tags") return read_tags(top, first_id);
  if (name == "points") return read_points(top, first_id);
  if (name == "checkerboard") return read_checkerboard(top, first_id, warnings);
  if (name == "charuco") return read_charuco(top, first_id);
  if (name == "circlegrid") return read_circles(top, first_id, warnings);
  type.fail(kTypes);
}

std::string kind_yaml(const AprilGrid& grid) {
  return fmt::format(
      "target_type: aprilgrid\ntagCols: {}\ntagRows: {}\ntagSize: {}\ntagSpacing: {}\n"
      "first_id: {}\nfamily: {}\nborder_bits: {}\ncorner_squares: {}\n",
      grid.columns, grid.rows, grid.tag_size, grid.tag_spacing, grid.first_id,
      text_yaml(grid.family), grid.border_bits, grid.corner_squares);
}

std::string kind_yaml(const Checkerboard& board) {
  return fmt::format(
      "target_type: checkerboard\ntargetCols: {}\ntargetRows: {}\nrowSpacingMeters: {}\n"
      "colSpacingMeters: {}\nfirst_id: {}\nstarts_black: {}\n",
      board.columns, board.rows, board.row_spacing, board.column_spacing, board.first_id,
      board.starts_black);
}

std::string kind_yaml(const CircleGrid& grid) {
  return fmt::format(
      "target_type: circlegrid\ntargetCols: {}\ntargetRows: {}\nspacingMeters: {}\n"
      "asymmetricGrid: {}\ndiameterMeters: {}\nfirst_id: {}\n",
      grid.columns, grid.rows, grid.spacing, grid.asymmetric, grid.diameter, grid.first_id);
}

std::string kind_yaml(const Charuco& board) {
  return fmt::format(
      "target_type: charuco\nsquareCols: {}\nsquareRows: {}\nsquareSize: {}\nmarkerSize: {}\n"
      "dictionary: {}\nlegacy: {}\nfirst_id: {}\nfirst_marker_id: {}\n",
      board.square_columns, board.square_rows, board.square_size, board.marker_size,
      text_yaml(board.dictionary), board.legacy, board.first_id, board.first_marker_id);
}

std::string kind_yaml(const Tags& board) {
  std::string text =
      fmt::format("target_type: tags\nfamily: {}\nborder_bits: {}\ncorner_squares: false\ntags:\n",
                  text_yaml(board.family), board.border_bits);
  for (const Tag& tag : board.tags)
    text += fmt::format("  - {{id: {}, size: {}, pose: {}}}\n", tag.id, tag.size,
                        pose_yaml(tag.board_from_tag));
  return text;
}

std::string kind_yaml(const Points& board) {
  std::string text = "target_type: points\npoints:\n";
  for (const TargetPoint& point : board.points)
    text += fmt::format("  - [{}, {}, {}, {}]\n", point.id.tag_id, point.position.x(),
                        point.position.y(), point.position.z());
  return text;
}

// Nothing for the default.
std::string tolerance_yaml(const char* key, const Tolerance& tolerance) {
  if (const double* const share = std::get_if<double>(&tolerance))
    return fmt::format("{}: {}\n", key, *share);
  const Material material = std::get<Material>(tolerance);
  return material == Material::paper ? "" : fmt::format("{}: {}\n", key, material_name(material));
}

}  // namespace

Board board_from_yaml(const YamlValue& top, std::optional<int> first_id,
                      std::vector<std::string>* warnings, std::optional<double> tag_size_m) {
  if (is_field_layout(top)) return read_field_layout(top, first_id, tag_size_m, warnings);
  if (!top.find("target_type")) top.refuse_other_kind("a target file");
  const YamlValue type = top.at("target_type");
  if (tag_size_m)
    top.fail_plainly("states the size of its tags: only a field layout of WPILib can be given one");
  BoardPattern pattern = read_kind(type, top, first_id, warnings);
  return make_board(std::move(pattern),
                    {read_tolerance(top, "flatness"), read_tolerance(top, "print")});
}

std::string board_yaml(const Board& board) {
  return std::visit([](const auto& kind) { return kind_yaml(kind); }, board.pattern) +
         tolerance_yaml("flatness", board.substrate.flatness) +
         tolerance_yaml("print", board.substrate.print);
}

}  // namespace tagcal::internal
