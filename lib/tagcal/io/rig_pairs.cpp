#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/dataset/csv_rows.hpp"
#include "tagcal/io/rig_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

using ViewByName = std::map<std::string, std::size_t>;

// The views of a camera by the name of the picture, with and without its folder.
ViewByName views_by_name(const RigCamera& camera) {
  ViewByName views;
  for (std::size_t i = 0; i < camera.data.views.size(); ++i) {
    const std::string& image = camera.data.views[i].image;
    views.emplace(image, i);
    views.emplace(std::filesystem::path(image).filename().string(), i);
  }
  return views;
}

std::optional<std::size_t> find_view(const ViewByName& views, const std::string& name) {
  if (name.empty()) return std::nullopt;
  auto found = views.find(name);
  if (found == views.end()) found = views.find(std::filesystem::path(name).filename().string());
  if (found == views.end()) return std::nullopt;
  return found->second;
}

// The index of the camera of each column.
std::vector<std::size_t> cameras_of_columns(const std::string& file,
                                            const std::vector<std::string>& header,
                                            const std::vector<RigCamera>& cameras) {
  std::vector<std::size_t> columns;
  for (const std::string& name : header) {
    const auto camera = std::ranges::find(cameras, name, &RigCamera::name);
    const auto c = static_cast<std::size_t>(camera - cameras.begin());
    if (camera == cameras.end())
      throw Error(fmt::format("{}: line 1: {} is the name of no camera", file, shown(name)));
    if (std::ranges::find(columns, c) != columns.end())
      throw Error(fmt::format("{}: line 1: {} has two columns", file, shown(name)));
    columns.push_back(c);
  }
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (std::ranges::find(columns, c) == columns.end())
      throw Error(fmt::format("{}: line 1: has no column for camera {}", file, cameras[c].name));
  return columns;
}

// Puts the views of a column into the instants, which are as many as rows.
void pair_column(const CsvRows& rows, std::size_t column, const RigCamera& camera, std::size_t c,
                 std::vector<Instant>& instants) {
  const ViewByName views = views_by_name(camera);
  std::vector<bool> is_paired(camera.data.views.size());
  for (std::size_t r = 0; r < rows.rows().size(); ++r) {
    const CsvRow& row = rows.rows()[r];
    const auto view = find_view(views, row.fields[column]);
    if (!view) continue;
    if (is_paired[*view])
      rows.fail(row, fmt::format("{} of camera {} is in a row before it", shown(row.fields[column]),
                                 camera.name));
    is_paired[*view] = true;
    instants[r].view[c] = view;
  }
}

// Names of a column that are no view: nothing may have been seen there, or all are misspelt.
void check_names(const std::string& file, const CsvRows& rows, std::size_t column,
                 const RigCamera& camera, std::vector<std::string>* notes) {
  const ViewByName views = views_by_name(camera);
  std::size_t num_names = 0, num_unknown = 0;
  std::string unknown;
  for (const CsvRow& row : rows.rows()) {
    const std::string& name = row.fields[column];
    if (name.empty()) continue;
    ++num_names;
    if (find_view(views, name)) continue;
    if (num_unknown++ == 0) unknown = name;
  }
  if (num_unknown == 0) return;
  const std::string message = fmt::format("{}: {} names of camera {} are no view of it, {} first",
                                          file, num_unknown, camera.name, shown(unknown));
  if (num_unknown == num_names) throw Error(message);
  if (notes) notes->push_back(message);
}

}  // namespace

std::vector<Instant> pair_by_file(const std::filesystem::path& file,
                                  const std::vector<RigCamera>& cameras,
                                  std::vector<std::string>* notes) {
  const CsvRows rows(file);
  const auto columns = cameras_of_columns(file.string(), rows.header(), cameras);
  const Instant none{std::vector<std::optional<std::size_t>>(cameras.size())};
  std::vector<Instant> instants(rows.rows().size(), none);
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const std::size_t c = columns[column];
    check_names(file.string(), rows, column, cameras[c], notes);
    pair_column(rows, column, cameras[c], c, instants);
  }
  std::erase_if(instants, [](const Instant& instant) {
    return std::ranges::none_of(instant.view, [](const auto& view) { return view.has_value(); });
  });
  return instants;
}

}  // namespace tagcal
