#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <unordered_map>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/corners_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr std::array<std::string_view, 8> kColumns = {"image", "tag_id",  "corner",  "x_px",
                                                      "y_px",  "sxx_px2", "sxy_px2", "syy_px2"};

constexpr std::string_view kTime = "time_s";

std::string header(std::size_t num_columns) {
  return fmt::format("{}", fmt::join(kColumns.begin(), kColumns.begin() + num_columns, ","));
}

// The corners of each id: bit k of the value is corner k.
std::unordered_map<int, unsigned> corners_by_id(const std::vector<PlacedBoard>& boards) {
  std::unordered_map<int, unsigned> corners;
  for (const PlacedBoard& placed : boards) {
    for (const TargetPoint& point : target_points(placed.board))
      corners[point.id.tag_id] |= 1U << point.id.corner;
  }
  return corners;
}

class ObservationReader {
 public:
  ObservationReader(const std::filesystem::path& file, const std::vector<PlacedBoard>& boards)
      : file_(file.string()), corners_(corners_by_id(boards)) {}

  std::vector<View> read(std::string_view text) {
    if (trimmed(text).empty()) throw Error(file_ + ": is empty");
    for_each_line(text, [&](std::string_view line, std::size_t number) {
      line_ = number;
      if (num_columns_ == 0) {
        take_header(line);
      } else if (!trimmed(line).empty()) {
        take_row(line);
      }
    });
    for (std::size_t i = 0; i < views_.size(); ++i) check_once(i);
    return std::move(views_);
  }

  const std::map<std::string, double>& times_s() const { return times_s_; }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(fmt::format("{}: line {}: {}", file_, line_, message));
  }
  [[noreturn]] void fail(std::size_t column, const std::string& must) const {
    fail(fmt::format("{}: {}, got {}", kColumns[column], must,
                     field(column).empty() ? "nothing" : shown(field(column))));
  }

  std::string_view field(std::size_t column) const { return csv_.fields()[column]; }

  const std::vector<std::string_view>& split(std::string_view line) {
    const std::string_view defect = csv_.split(line);
    if (!defect.empty()) fail(std::string(defect));
    return csv_.fields();
  }

  void take_header(std::string_view line) {
    const std::vector<std::string_view>& fields = split(line);
    // Frames of videos and bags have a time, which decides nothing; tags that were found without a
    // board have one more column, which adds nothing on a board.
    has_times_ = fields.back() == kTime;
    const bool has_instance = fields.back() == "instance";
    const std::size_t named = fields.size() - (has_instance || has_times_ ? 1 : 0);
    bool is_header = named == 5 || named == 8;
    for (std::size_t i = 0; is_header && i < named; ++i) is_header = fields[i] == kColumns[i];
    has_covariances_ = named == 8;
    if (!is_header) {
      fail(fmt::format("the header must be {}, or {}; got {}", header(5), header(8), shown(line)));
    }
    num_columns_ = fields.size();
  }

  double number(std::size_t column) const {
    const auto value = parse_number(field(column));
    if (!value) fail(column, "must be a finite number");
    return *value;
  }

  int whole(std::size_t column) const {
    const auto value = parse_whole(field(column));
    if (!value) fail(column, "must be a whole number");
    return *value;
  }

  CornerId corner_id() const {
    const CornerId id{whole(1), whole(2)};
    const auto found = corners_.find(id.tag_id);
    if (found == corners_.end()) fail(1, "must be an id on the boards");
    if (id.corner < 0 || id.corner > 3 || (found->second >> id.corner & 1U) == 0) {
      fail(2, found->second == 1U ? "must be 0 for a point" : "must be from 0 to 3");
    }
    return id;
  }

  std::optional<Matrix2> covariance() const {
    // The covariance is optional for each corner.
    if (field(5).empty() && field(6).empty() && field(7).empty()) return std::nullopt;
    const double sxx = number(5), sxy = number(6), syy = number(7);
    if (!(sxx > 0)) fail(5, "must be > 0");
    if (!(syy > 0)) fail(7, "must be > 0");
    // The determinant would underflow.
    if (!(std::abs(sxy) < std::sqrt(sxx) * std::sqrt(syy))) {
      fail(6, "the covariance must be positive definite");
    }
    Matrix2 matrix;
    matrix << sxx, sxy, sxy, syy;
    return matrix;
  }

  void take_row(std::string_view line) {
    const std::size_t num_fields = split(line).size();
    if (num_fields != num_columns_)
      fail(fmt::format("must have {} fields, got {}", num_columns_, num_fields));
    if (!is_image_name(field(0))) fail(0, "must be the name of an image");
    Observation observation;
    observation.id = corner_id();
    observation.pixel = {number(3), number(4)};
    if (has_covariances_) observation.covariance_px2 = covariance();
    const std::size_t view = view_of(field(0));
    if (has_times_ && !field(num_columns_ - 1).empty()) take_time(field(num_columns_ - 1), view);
    views_[view].observations.push_back(observation);
    lines_[view].push_back(line_);
  }

  void take_time(std::string_view text, std::size_t view) {
    const auto time = parse_number(text);
    if (!time) fail(fmt::format("{}: must be a finite number, got {}", kTime, shown(text)));
    const auto [known, is_new] = times_s_.emplace(views_[view].image, *time);
    if (known->second != *time)
      fail(fmt::format("{}: must be {:.6f} as before for this image, got {}", kTime, known->second,
                       shown(text)));
  }

  std::size_t view_of(std::string_view image) {
    if (!views_.empty() && views_[current_].image == image) return current_;
    const auto [found, is_new] = view_of_image_.emplace(image, views_.size());
    if (is_new) {
      views_.push_back({std::string(image), {}});
      lines_.emplace_back();
    }
    return current_ = found->second;
  }

  void check_once(std::size_t view) {
    std::vector<std::pair<CornerId, std::size_t>> seen;
    const std::vector<Observation>& observations = views_[view].observations;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      seen.emplace_back(observations[i].id, lines_[view][i]);
    }
    std::sort(seen.begin(), seen.end());
    for (std::size_t i = 1; i < seen.size(); ++i) {
      if (seen[i].first != seen[i - 1].first) continue;
      line_ = seen[i].second;
      fail(fmt::format("corner {} of tag {} is given twice in image {}, first in line {}",
                       seen[i].first.corner, seen[i].first.tag_id, shown(views_[view].image),
                       seen[i - 1].second));
    }
  }

  std::string file_;
  std::unordered_map<int, unsigned> corners_;
  std::vector<View> views_;
  std::vector<std::vector<std::size_t>> lines_;       // line of each observation
  std::map<std::string, std::size_t> view_of_image_;  // a hash would have collisions on purpose
  std::size_t current_ = 0;                           // the view of the previous row
  std::size_t line_ = 0;
  std::size_t num_columns_ = 0;
  bool has_covariances_ = false;
  bool has_times_ = false;
  std::map<std::string, double> times_s_;
  CsvFields csv_;
};

// A line without the columns behind those of the covariance, and without its end.
void add_corner(const std::string& image, const Observation& o, bool has_covariances,
                fmt::memory_buffer& out) {
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "{},{},{},{},{}", image, o.id.tag_id, o.id.corner, o.pixel.x(), o.pixel.y());
  if (o.covariance_px2) {
    const Matrix2& s = *o.covariance_px2;
    fmt::format_to(end, ",{},{},{}", s(0, 0), s(0, 1), s(1, 1));
  } else if (has_covariances) {
    fmt::format_to(end, ",,,");
  }
}

}  // namespace

std::vector<View> read_observations(const std::filesystem::path& file,
                                    const std::vector<PlacedBoard>& boards,
                                    std::vector<std::string>* notes,
                                    std::map<std::string, double>* times_s) {
  const std::string text = read_plain_text(file);
  if (is_vnl(text)) return read_vnl(text, file.string(), boards, notes);
  if (is_image_points(text)) return read_image_points(text, file.string(), boards, notes);
  ObservationReader reader(file, boards);
  std::vector<View> views = reader.read(text);
  if (times_s != nullptr) *times_s = reader.times_s();
  return views;
}

std::string observations_csv(const std::vector<View>& views,
                             const std::map<std::string, double>& times_s) {
  bool has_covariances = false;
  for (const View& view : views) {
    for (const Observation& o : view.observations) has_covariances |= o.covariance_px2.has_value();
  }
  fmt::memory_buffer out;
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "{}{}\n", header(has_covariances ? 8 : 5),
                 times_s.empty() ? "" : fmt::format(",{}", kTime));
  std::set<std::string_view> names;
  for (const View& view : views) {
    const std::string image = image_field(view.image);
    if (!names.insert(view.image).second)
      throw Error(fmt::format("image: two views have the name {}", shown(view.image)));
    const auto time = times_s.find(view.image);
    std::string last = times_s.empty() ? "" : ",";
    if (time != times_s.end()) last += fmt::format("{:.6f}", time->second);
    for (const Observation& o : view.observations) {
      add_corner(image, o, has_covariances, out);
      fmt::format_to(end, "{}\n", last);
    }
  }
  return fmt::to_string(out);
}

std::string tags_csv(const std::vector<std::string>& images,
                     const std::vector<std::vector<DetectedTag>>& tags) {
  const bool has_covariances = std::ranges::any_of(tags, [](const auto& of_image) {
    return std::ranges::any_of(of_image,
                               [](const DetectedTag& t) { return t.covariance_px2.has_value(); });
  });
  fmt::memory_buffer out;
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "image,tag_id,corner,x_px,y_px{},instance\n",
                 has_covariances ? ",sxx_px2,sxy_px2,syy_px2" : "");
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string image = image_field(images[i]);
    std::map<int, int> count;
    for (const DetectedTag& tag : tags[i]) {
      const int instance = count[tag.id]++;
      for (int c = 0; c < 4; ++c) {
        Observation seen{{tag.id, c}, tag.corners[static_cast<std::size_t>(c)], {}};
        if (tag.covariance_px2) seen.covariance_px2 = tag.covariance_px2->block<2, 2>(2 * c, 2 * c);
        add_corner(image, seen, has_covariances, out);
        fmt::format_to(end, ",{}\n", instance);
      }
    }
  }
  return fmt::to_string(out);
}

}  // namespace tagcal
