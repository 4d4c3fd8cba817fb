#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>

#include "job/camera_input.hpp"
#include "job/point_table.hpp"
#include "report/fleet.hpp"
#include "report/history_report.hpp"
#include "report/lens_comparison.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// Sets the keys to the days from the first, if all names have dates, and else to 0, 1, ..
void set_dates_or_order(HistoryInput& input) {
  for (std::size_t i = 0; i < input.names.size(); ++i) {
    const auto days = named_unit(fs::path(input.names[i]).stem().string()).days;
    if (!days) break;
    input.keys.push_back(*days);
  }
  input.key = "days";
  if (input.keys.size() == input.names.size()) {
    const double first = *std::ranges::min_element(input.keys);
    for (double& key : input.keys) key -= first;
    return;
  }
  input.key = "order";
  input.keys.clear();
  for (std::size_t i = 0; i < input.names.size(); ++i) input.keys.push_back(static_cast<double>(i));
}

void set_keys_of_table(HistoryInput& input, const std::string& file) {
  const PointTable table = PointTable::read(file);
  const std::size_t name = table.need({{"name"}}).front();
  const std::size_t value = table.need({{input.key}, {"value"}}).front();
  std::map<std::string, std::size_t> rows;
  for (std::size_t i = 0; i < table.size(); ++i)
    if (!rows.emplace(table.fields(i)[name], i).second) table.fail(i, {name}, "must be given once");
  for (const std::string& camera : input.names) {
    auto row = rows.end();
    for (const std::string& shown :
         {camera, fs::path(camera).filename().string(), fs::path(camera).stem().string()})
      if (row == rows.end()) row = rows.find(shown);
    if (row == rows.end()) throw Error(fmt::format("{}: has no line of {}", file, camera));
    input.keys.push_back(table.numbers(row->second, {value}).front());
  }
}

void set_keys(HistoryInput& input, const std::string& values) {
  if (!values.empty()) return set_keys_of_table(input, values);
  if (input.key.empty()) return set_dates_or_order(input);
  for (const std::string& file : input.names)
    input.keys.push_back(internal::YamlValue::read(file).at(input.key).number());
}

}  // namespace

HistoryInput read_history(const std::vector<std::string>& files, const std::string& key,
                          const std::string& values) {
  constexpr std::size_t kFewest = 2;
  if (files.size() < kFewest)
    throw Error(fmt::format("{}: must be two calibrations or more", files.front()));
  HistoryInput input{key.empty() && !values.empty() ? "value" : key, files, {}, {}, {}, {}};
  std::optional<CalibrationFile> first;
  for (const std::string& file : files) {
    const CalibrationFile camera = read_camera(file);
    input.cameras.push_back(uncertain_camera(camera));
    if (!first) {
      first = camera;
      input.samples = common_region(camera, camera);
    }
    if (!camera.seen.hull().empty())
      std::erase_if(input.samples,
                    [&](const Eigen::Vector2d& pixel) { return !camera.seen.contains(pixel); });
    const Camera &before = first->camera, &now = camera.camera;
    const bool is_comparable = before.image_size == now.image_size && kind_of(now.lens).is_central;
    const auto difference =
        is_comparable ? lens_difference(before, now, input.samples, kInfinitelyFar) : std::nullopt;
    input.displacements_px.push_back(difference ? difference->max_px
                                                : std::numeric_limits<double>::quiet_NaN());
  }
  set_keys(input, values);
  return input;
}

CameraHistory history_of(const HistoryInput& input) {
  try {
    return estimate_history(input.cameras, input.keys, input.samples);
  } catch (const Error& error) {
    const std::string_view what = error.what();
    for (std::size_t i = 0; i < input.names.size(); ++i)
      if (const std::string number = fmt::format("calibration {}: ", i + 1);
          what.starts_with(number))
        throw Error(fmt::format("{}: {}", input.names[i], what.substr(number.size())));
    throw;
  }
}

}  // namespace tagcal::tools
