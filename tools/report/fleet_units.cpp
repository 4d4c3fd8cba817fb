#include "report/fleet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <map>
#include <unordered_set>

#include "job/point_table.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/calibration_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// Days since 1970 of "2026-03-01".
std::optional<double> days_of(std::string_view date) {
  constexpr std::size_t kLength = 10, kMonth = 5, kDay = 8;
  if (date.size() != kLength || date[kMonth - 1] != '-' || date[kDay - 1] != '-')
    return std::nullopt;
  const auto number = [&](std::size_t at, std::size_t length) {
    int value = -1;
    const char* const end = date.data() + at + length;
    return std::from_chars(date.data() + at, end, value).ptr == end ? value : -1;
  };
  const std::chrono::year_month_day day{
      std::chrono::year(number(0, kMonth - 1)),
      std::chrono::month(static_cast<unsigned>(number(kMonth, 2))),
      std::chrono::day(static_cast<unsigned>(number(kDay, 2)))};
  if (!day.ok() || number(0, kMonth - 1) < 0) return std::nullopt;
  return std::chrono::sys_days(day).time_since_epoch().count();
}

}  // namespace

FleetUnit named_unit(std::string name) {
  FleetUnit unit;
  constexpr std::size_t kDate = 10;
  unit.serial = name;
  if (name.size() > kDate + 1 &&
      std::string_view("_-@.").find(name[name.size() - kDate - 1]) != std::string_view::npos) {
    const std::string date = name.substr(name.size() - kDate);
    unit.days = days_of(date);
    if (unit.days) {
      unit.date = date;
      unit.serial = name.substr(0, name.size() - kDate - 1);
    }
  }
  unit.row.name = std::move(name);
  return unit;
}

namespace {

FleetRow row_of_camera(const fs::path& file) {
  FleetRow row;
  try {
    row = fleet_row(file.stem().string(), read_calibration(file));
  } catch (const std::exception& error) {
    row.reason = error.what();  // without a status: it is no calibration
  }
  row.name = file.stem().string();
  return row;
}

bool may_be_camera(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".yaml" || ending == ".yml" || ending == ".json" || ending == ".xml";
}

struct FleetFiles {
  std::vector<fs::path> summaries;
  std::vector<fs::path> cameras;                 // without a summary
  std::unordered_set<std::string> calibrations;  // names of the files NAME.yaml
};

FleetFiles files_of(const fs::path& folder) {
  FleetFiles files;
  std::error_code why;
  std::unordered_set<std::string> summarised;
  for (const auto& entry : fs::directory_iterator(folder / kSummaryFolder, why)) {
    if (entry.path().extension() != ".json") continue;
    files.summaries.push_back(entry.path());
    summarised.insert(entry.path().stem().string());
  }
  for (const auto& entry : fs::directory_iterator(folder, why)) {
    const std::string name = entry.path().stem().string();
    if (!may_be_camera(entry.path()) || !entry.is_regular_file()) continue;
    if (entry.path().extension() == ".yaml") files.calibrations.insert(name);
    if (!summarised.contains(name)) files.cameras.push_back(entry.path());
  }
  if (why) throw Error(fmt::format("{}: cannot be read: {}", folder.string(), why.message()));
  return files;
}

// The columns of the table, and its row of each name.
class UnitTable {
 public:
  explicit UnitTable(const fs::path& file) : table_(PointTable::read(file.string())) {
    const std::size_t name = table_.need({{"name"}}).front();
    for (const std::string& column : table_.names())
      if (column != "name" && column != "serial" && column != "date" && column != "temperature_c")
        throw Error(fmt::format("{}: {}: is no column of units: name, serial, date, temperature_c",
                                file.string(), column));
    for (std::size_t i = 0; i < table_.size(); ++i)
      if (!rows_.emplace(table_.fields(i)[name], i).second)
        table_.fail(i, {name}, "must be given once");
  }

  // Takes what the table says of a unit.
  void apply(FleetUnit& unit) {
    const auto row = rows_.find(unit.row.name);
    if (row == rows_.end()) return;
    const std::size_t at = row->second;
    if (const auto column = filled(at, "serial")) unit.serial = table_.fields(at)[*column];
    if (const auto column = filled(at, "date")) {
      unit.date = table_.fields(at)[*column];
      unit.days = days_of(unit.date);
      if (!unit.days) table_.fail(at, {*column}, "must be a date such as 2026-03-01");
    }
    if (const auto column = filled(at, "temperature_c"))
      unit.temperature_c = table_.numbers(at, {*column}).front();
    rows_.erase(row);
  }

  // Throws Error for the first name that is no unit.
  void check_all_used() const {
    const auto first = std::ranges::min_element(rows_, {}, [](const auto& r) { return r.second; });
    if (first != rows_.end())
      table_.fail(first->second, table_.need({{"name"}}), "must be a calibration of the folder");
  }

 private:
  std::optional<std::size_t> filled(std::size_t row, const std::string& name) const {
    const std::vector<std::size_t> columns = table_.find({{name}});
    if (columns.empty() || table_.is_empty(row, columns)) return std::nullopt;
    return columns.front();
  }

  PointTable table_;
  std::map<std::string, std::size_t> rows_;  // that no unit has taken
};

}  // namespace

FleetInput read_fleet(const fs::path& folder, const fs::path& table, int threads) {
  if (!fs::is_directory(folder))
    throw Error(fmt::format("{}: must be the folder of tagcal calibrate --out", folder.string()));
  const FleetFiles files = files_of(folder);
  std::vector<FleetUnit> units(files.summaries.size() + files.cameras.size());
  internal::parallel_for(units.size(), threads, [&](std::size_t i) {
    const std::size_t s = files.summaries.size();
    FleetRow row = i < s ? read_summary(files.summaries[i]) : row_of_camera(files.cameras[i - s]);
    if (i < s && row.status == "ok" && !files.calibrations.contains(row.name))
      row.reason = fmt::format("{}.yaml is missing", row.name);
    units[i] = named_unit(row.name);
    units[i].row = std::move(row);
  });
  FleetInput input;
  for (FleetUnit& unit : units) {
    if (unit.row.status.empty())
      input.warnings.push_back("no calibration: " + unit.row.reason);
    else
      input.units.push_back(std::move(unit));
  }
  if (input.units.empty())
    throw Error(fmt::format("{}: has no calibrations; tagcal calibrate SETS --out writes them",
                            folder.string()));
  std::ranges::sort(
      input.units, {}, [](const FleetUnit& u) -> auto& { return u.row.name; });
  if (!table.empty()) {
    UnitTable known(table);
    for (FleetUnit& unit : input.units) known.apply(unit);
    known.check_all_used();
  }
  return input;
}

}  // namespace tagcal::tools
