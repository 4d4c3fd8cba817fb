#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/formats/text_lines.hpp"

namespace tagcal::internal {
namespace {

// Columns of the legend, by name.
struct Legend {
  std::size_t num_columns = 0;
  std::size_t filename = 0;
  std::size_t x = 0;
  std::size_t y = 0;
  std::optional<std::size_t> level;  // of decimation; or of a weight, which is not used
};

// The words of the first line that begins with one #; ## is a comment.
std::vector<std::string> legend_words(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    if (line[first] != '#') return {};
    const bool comment =
        line.size() > first + 1 && (line[first + 1] == '#' || line[first + 1] == '!');
    if (comment) continue;
    TextLines words("", line.substr(first + 1));
    if (!words.next()) continue;
    return {words.words().begin(), words.words().end()};
  }
  return {};
}

Legend read_legend(const std::string& text, const std::string& file) {
  const std::vector<std::string> words = legend_words(text);
  const auto column = [&](std::string_view name) {
    const auto found = std::ranges::find(words, name);
    if (found == words.end())
      throw Error(fmt::format("{}: the legend must have a column {}", file, name));
    if (std::ranges::count(words, name) > 1)
      throw Error(fmt::format("{}: the legend has the column {} twice", file, name));
    return static_cast<std::size_t>(found - words.begin());
  };
  Legend legend{words.size(), column("filename"), column("x"), column("y"), {}};
  if (std::ranges::count(words, "level") > 0) legend.level = column("level");
  return legend;
}

class VnlReader {
 public:
  VnlReader(const std::string& text, const std::string& file, std::vector<CornerId> corners)
      : lines_(file, text), legend_(read_legend(text, file)), corners_(std::move(corners)) {}

  std::vector<View> read(std::vector<std::string>* notes) {
    while (lines_.next()) {
      if (lines_.words().size() != legend_.num_columns)
        lines_.fail(fmt::format("must have {} columns, got {}", legend_.num_columns,
                                lines_.words().size()));
      const std::string image(lines_.words()[legend_.filename]);
      if (views_.empty() || views_.back().image != image) begin(image);
      take();
    }
    end();
    std::erase_if(views_, [](const View& view) { return view.observations.empty(); });
    if (num_coarse_ > 0 && notes)
      notes->push_back(fmt::format(
          "{} corners have a level above 0 (found in a smaller picture): they count as much as the "
          "others",
          num_coarse_));
    return std::move(views_);
  }

 private:
  void begin(const std::string& image) {
    end();
    if (!names_.insert(image).second)
      lines_.fail(fmt::format("filename: the lines of {} must follow each other", shown(image)));
    views_.push_back({image, {}});
    num_lines_ = 0;
  }

  // A picture without corners has one line.
  void end() const {
    if (views_.empty() || num_lines_ == corners_.size()) return;
    if (num_lines_ == 1 && views_.back().observations.empty()) return;
    lines_.fail(fmt::format("picture {} has {} lines, but the target {} corners",
                            shown(views_.back().image), num_lines_, corners_.size()));
  }

  void take() {
    const std::size_t corner = num_lines_++;
    if (corner >= corners_.size())
      lines_.fail(fmt::format("picture {} has more lines than the target has corners, {}",
                              shown(views_.back().image), corners_.size()));
    const auto word = [&](std::size_t i) { return lines_.words()[i]; };
    if (word(legend_.x) == "-" || word(legend_.y) == "-") return;
    if (legend_.level) {
      if (word(*legend_.level) == "-") return;
      const double level = lines_.number(*legend_.level, "level");
      if (level < 0) return;
      num_coarse_ += level > 0 ? 1 : 0;
    }
    Observation observation;
    observation.id = corners_[corner];
    observation.pixel = {lines_.number(legend_.x, "x"), lines_.number(legend_.y, "y")};
    views_.back().observations.push_back(observation);
  }

  TextLines lines_;
  Legend legend_;
  std::vector<CornerId> corners_;
  std::vector<View> views_;
  std::set<std::string> names_;
  std::size_t num_lines_ = 0;  // of the last view
  int num_coarse_ = 0;
};

}  // namespace

bool is_vnl(std::string_view text) {
  const std::vector<std::string> words = legend_words(text);
  return std::ranges::count(words, "filename") > 0 && std::ranges::count(words, "x") > 0;
}

std::vector<View> read_vnl(const std::string& text, const std::string& file,
                           const std::vector<PlacedBoard>& boards,
                           std::vector<std::string>* notes) {
  return VnlReader(text, file, listed_corners(boards, file)).read(notes);
}

std::string vnl_text(const std::vector<View>& views, const std::vector<PlacedBoard>& boards) {
  const std::vector<CornerId> corners = listed_corners(boards, "corners.vnl");
  std::string text = "# filename x y level\n";
  for (const View& view : views) {
    if (view.image.empty() || view.image.find_first_of(" \t\r\n#") != std::string::npos)
      throw Error(
          fmt::format("a column of a vnl file has no spaces and no #: the name {} must "
                      "have none",
                      shown(view.image)));
    std::map<CornerId, Eigen::Vector2d> pixels;
    for (const Observation& o : view.observations) pixels.emplace(o.id, o.pixel);
    for (const CornerId& id : corners) {
      const auto found = pixels.find(id);
      text += found == pixels.end()
                  ? fmt::format("{} - - -\n", view.image)
                  : fmt::format("{} {} {} 0\n", view.image, found->second.x(), found->second.y());
    }
  }
  return text;
}

std::vector<CornerId> listed_corners(const std::vector<PlacedBoard>& boards,
                                     const std::string& where) {
  if (boards.size() != 1)
    throw Error(fmt::format("{}: a list of corners needs a data set of one board, not {}", where,
                            boards.size()));
  const Board& board = boards[0].board;
  std::vector<CornerId> corners;
  if (const auto grid = point_grid(board)) {
    for (int row = grid->rows - 1; row >= 0; --row)
      for (int column = 0; column < grid->columns; ++column)
        corners.push_back({grid->first_id + row * grid->columns + column, 0});
    return corners;
  }
  if (point_kind(board) == PointKind::tag_corner)
    throw Error(where +
                ": a list of corners in order needs a target of type checkerboard, charuco, "
                "circlegrid or points: the corners of tags are no regular grid");
  for (const TargetPoint& point : target_points(board)) corners.push_back(point.id);
  return corners;
}

std::string view_name(std::size_t index) { return fmt::format("view{:04}", index); }

}  // namespace tagcal::internal
