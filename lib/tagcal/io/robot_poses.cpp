#include "tagcal/io/robot_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/dataset/pose_columns.hpp"
#include "tagcal/io/formats/text_lines.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTum = "time_s x_m y_m z_m qx qy qz qw";

// The lines of a table of poses.
class PoseTable {
 public:
  PoseTable(const fs::path& file, const std::string& columns) : file_(file.string()) {
    if (!columns.empty()) set_columns(words_of(columns == "tum" ? kTum : columns), true);
  }

  RobotPoses read(std::string_view text) {
    for_each_line(text, [&](std::string_view line, std::size_t number) {
      line_ = number;
      take(trimmed(line, " \t\r"));
    });
    if (poses_.base_from_hand.empty()) throw Error(file_ + ": has no pose");
    return std::move(poses_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(fmt::format("{}: line {}: {}", file_, line_, message));
  }

  void set_columns(const std::vector<std::string_view>& names, bool is_strict) {
    try {
      columns_.emplace(std::vector<std::string>(names.begin(), names.end()), is_strict);
    } catch (const Error& error) {
      if (is_strict) throw Error(fmt::format("--robot-format: {}", error.what()));
      fail(error.what());
    }
  }

  std::vector<std::string_view> split(std::string_view line) {
    if (line.find(',') == line.npos) return words_of(line);
    const std::string_view defect = csv_.split(line);
    if (!defect.empty()) fail(std::string(defect));
    return csv_.fields();
  }

  void take(std::string_view line) {
    // rostopic's first line begins with %time.
    if (line.empty() || line[0] == '#') return;
    const std::vector<std::string_view> fields = split(line);
    if (!columns_) {
      const bool is_header = std::ranges::none_of(
          fields, [](std::string_view f) { return parse_number(f).has_value(); });
      if (is_header) return set_columns(fields, false);
      if (fields.size() != words_of(kTum).size() || !parse_number(fields[0]))
        fail(
            "must name the columns, as image,x_m,y_m,z_m,qw,qx,qy,qz; or say what they are with "
            "--robot-format");
      set_columns(words_of(kTum), true);
    }
    try {
      add(fields);
    } catch (const Error& error) {
      fail(error.what());
    }
  }

  void add(const std::vector<std::string_view>& fields) {
    if (fields.size() != columns_->size())
      throw Error(fmt::format("must have {} fields, got {}", columns_->size(), fields.size()));
    if (const auto image = columns_->place(PoseColumn::image)) {
      const std::string name(fields[*image]);
      if (!images_.insert(name).second)
        throw Error(fmt::format("image: {} has a pose already", shown(name)));
      poses_.images.push_back(name);
    }
    if (columns_->has(PoseColumn::time)) {
      const double time_s = columns_->number(fields, PoseColumn::time);
      if (!poses_.times_s.empty() && !(time_s > poses_.times_s.back()))
        throw Error("the times must increase from line to line");
      poses_.times_s.push_back(time_s);
    }
    poses_.base_from_hand.push_back(columns_->pose(fields));
    poses_.form = columns_->form();
    if (poses_.form.rotation != RotationForm::matrix)
      poses_.rotations.push_back(columns_->rotation_numbers(fields));
  }

  std::string file_;
  std::size_t line_ = 0;
  CsvFields csv_;
  std::optional<PoseColumns> columns_;
  std::set<std::string> images_;
  RobotPoses poses_;
};

// {rows: 6, cols: 1, data: [[x], [y], [z], [ux], [uy], [uz]]}.
Pose read_pose_vector(const fs::path& file) {
  const YamlValue top = YamlValue::read(file);
  const YamlValue data = top.at("data");
  Vector6d v;
  const std::vector<YamlValue> rows = data.items(6, 6);
  for (std::size_t i = 0; i < 6; ++i)
    v[static_cast<Eigen::Index>(i)] = rows[i].is_list() ? rows[i].numbers(1)[0] : rows[i].number();
  return {exp_rotation(v.tail<3>()), v.head<3>()};
}

RobotPoses read_pose_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".yaml" || extension == ".yml") files.push_back(entry.path());
  }
  if (files.empty()) throw Error(folder.string() + ": has no .yaml file of a pose");
  std::ranges::sort(files, {}, order_of_numbers);
  RobotPoses poses;
  poses.form = {RotationForm::vector, 1, false};
  for (const fs::path& file : files) poses.base_from_hand.push_back(read_pose_vector(file));
  return poses;
}

}  // namespace

std::tuple<std::size_t, std::string, std::string> order_of_numbers(const fs::path& file) {
  const std::string name = file.stem().string();
  const std::size_t end = name.find_last_of("0123456789");
  if (end == name.npos) return {0, "", name};
  const std::size_t before = name.find_last_not_of("0123456789", end);
  std::string digits = name.substr(before + 1, end - before);  // npos + 1 is 0
  digits.erase(0, digits.find_first_not_of('0'));
  return {digits.size(), digits, name};
}

RobotPoses read_robot_poses(const fs::path& file, const std::string& columns) {
  if (!fs::is_directory(file)) return PoseTable(file, columns).read(read_plain_text(file));
  if (!columns.empty())
    throw Error(file.string() +
                ": is a folder, whose files have a format of their own: leave out "
                "--robot-format");
  return read_pose_files(file);
}

}  // namespace tagcal
