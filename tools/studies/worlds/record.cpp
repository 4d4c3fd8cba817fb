#include "record.hpp"

#include <iterator>
#include <variant>

#include "tagcal/error.hpp"

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

study::Value value_of(const std::string& text) { return text; }
template <typename Number>
study::Value value_of(Number number) {
  return static_cast<double>(number);
}

// An empty text is read as a NaN (StudyOptions::csv).
void read(const study::Value& value, std::string& text) {
  const auto* found = std::get_if<std::string>(&value);
  text = found ? *found : "";
}
template <typename Number>
void read(const study::Value& value, Number& number) {
  const auto* found = std::get_if<double>(&value);
  if (!found) throw Error("a row of worlds has text where a number belongs");
  number = static_cast<Number>(*found);
}

}  // namespace

std::vector<std::string> record_columns() {
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.emplace_back(column.name);
  return names;
}

study::Values record_values(const Record& record) {
  study::Values values;
  for (const Column& column : kColumns)
    values.push_back(std::visit([&](auto field) { return value_of(record.*field); }, column.field));
  return values;
}

Record record_of(const study::Row& row) {
  Record record;
  record.index = row.trial;
  for (std::size_t i = 0; i < std::size(kColumns); ++i)
    std::visit([&](auto field) { read(row.values[i], record.*field); }, kColumns[i].field);
  return record;
}

}  // namespace tagcal
