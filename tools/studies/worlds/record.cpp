#include "record.hpp"

#include <fmt/format.h>

#include <charconv>
#include <variant>

#include "study/harness/csv.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
namespace {

using Field =
    std::variant<std::uint64_t Record::*, int Record::*, double Record::*, std::string Record::*>;

struct Column {
  std::string_view name;
  Field field;
};

const Column kColumns[] = {
    {"seed", &Record::seed},
    {"index", &Record::index},
    {"mode", &Record::mode},
    {"switches", &Record::switches},
    {"render_s", &Record::render_s},
    {"detect_s", &Record::detect_s},
    {"calibrate_s", &Record::calibrate_s},
    {"own_s", &Record::own_s},
    {"model", &Record::model},
    {"width", &Record::width},
    {"height", &Record::height},
    {"field_of_view_deg", &Record::field_of_view_deg},
    {"views", &Record::views},
    {"tags_on_board", &Record::tags_on_board},
    {"border_bits", &Record::border_bits},
    {"tag_px", &Record::tag_px},
    {"coverage", &Record::coverage},
    {"most_tilt_deg", &Record::most_tilt_deg},
    {"blur_px", &Record::blur_px},
    {"noise_levels", &Record::noise_levels},
    {"ink_spread_px", &Record::ink_spread_px},
    {"gamma", &Record::gamma},
    {"occluders", &Record::occluders},
    {"pictures", &Record::pictures},
    {"defects", &Record::defects},
    {"bend_x", &Record::bend_x},
    {"bend_y", &Record::bend_y},
    {"twist", &Record::twist},
    {"aspect", &Record::aspect},
    {"skew", &Record::skew},
    {"rows_px", &Record::rows_px},
    {"uneven_light", &Record::uneven_light},
    {"noise_px", &Record::noise_px},
    {"covariances", &Record::covariances},
    {"tags_visible", &Record::tags_visible},
    {"tags", &Record::tags},
    {"tags_fitted", &Record::tags_fitted},
    {"corners", &Record::corners},
    {"corners_without_covariance", &Record::corners_without_covariance},
    {"corners_hidden", &Record::corners_hidden},
    {"corners_beyond", &Record::corners_beyond},
    {"corner_squares", &Record::corner_squares},
    {"corner_worst", &Record::corner_worst},
    {"corner_worst_px", &Record::corner_worst_px},
    {"gross", &Record::gross},
    {"status", &Record::status},
    {"answer", &Record::answer},
    {"inliers", &Record::inliers},
    {"left_out", &Record::left_out},
    {"model_error_px", &Record::model_error_px},
    {"right_rejected", &Record::right_rejected},
    {"gross_kept", &Record::gross_kept},
    {"f_px", &Record::f_px},
    {"f_sd_px", &Record::f_sd_px},
    {"f_error_px", &Record::f_error_px},
    {"f_ratio", &Record::f_ratio},
    {"region_px", &Record::region_px},
    {"region_error_px", &Record::region_error_px},
    {"region_ratio", &Record::region_ratio},
    {"region_far_ratio", &Record::region_far_ratio},
    {"image_px", &Record::image_px},
    {"image_error_px", &Record::image_error_px},
    {"image_ratio", &Record::image_ratio},
    {"image_axis_ratio", &Record::image_axis_ratio},
    {"nodes_silent", &Record::nodes_silent},
    {"own_status", &Record::own_status},
    {"own_f_sd_px", &Record::own_f_sd_px},
    {"own_f_ratio", &Record::own_f_ratio},
    {"own_region_px", &Record::own_region_px},
    {"own_region_ratio", &Record::own_region_ratio},
    {"own_region_far_ratio", &Record::own_region_far_ratio},
    {"own_image_px", &Record::own_image_px},
    {"own_image_ratio", &Record::own_image_ratio},
    {"findings", &Record::findings},
};

std::string text_of(const Record& record, std::uint64_t Record::*field) {
  return std::to_string(record.*field);
}
std::string text_of(const Record& record, int Record::*field) {
  return std::to_string(record.*field);
}
std::string text_of(const Record& record, double Record::*field) {
  return fmt::format("{:.6g}", record.*field);
}
std::string text_of(const Record& record, std::string Record::*field) { return record.*field; }

template <typename Number>
bool parse(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}
bool parse(std::string_view text, std::string& value) {
  value = text;
  return true;
}

bool parse_record(std::string_view line, Record& record) {
  const std::vector<std::string> texts = study::csv_cells(line);
  if (texts.size() != std::size(kColumns)) return false;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto read = [&](auto field) { return parse(texts[i], record.*field); };
    if (!std::visit(read, kColumns[i].field)) return false;
  }
  return true;
}

}  // namespace

std::string record_header() {
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.emplace_back(column.name);
  return study::csv_line(names);
}

std::string record_line(const Record& record) {
  std::vector<std::string> fields;
  for (const Column& column : kColumns)
    fields.push_back(std::visit([&](auto field) { return text_of(record, field); }, column.field));
  return study::csv_line(fields);
}

std::vector<Record> read_records(const std::string& file) {
  const std::string text = read_text(file);
  std::vector<Record> records;
  std::string_view rest = text;
  if (!rest.starts_with(record_header()))
    throw Error(file + ": is not a file of worlds, or one with other columns");
  rest.remove_prefix(record_header().size());
  for (int number = 2; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) break;  // the program was stopped within the line
    Record record;
    if (!parse_record(rest.substr(0, end), record))
      throw Error(fmt::format("{}: line {} is not a world", file, number));
    records.push_back(record);
    rest.remove_prefix(end + 1);
  }
  return records;
}

}  // namespace tagcal
