// tagcal project and tagcal unproject: points to pixels and back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "job/point_table.hpp"
#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct ProjectArguments {
  std::string camera;
  std::string points = "-";
  std::string view;
  std::string out;
  double depth_m = 0;
  bool plane = false;
  bool json = false;
};

// A CSV in the making: the columns of the input, without those that the answer replaces, and those
// of the answer.
class Answer {
 public:
  Answer(const PointTable& table, const std::vector<std::string>& columns)
      : table_(table), num_columns_(columns.size()) {
    for (std::size_t i = 0; i < table.names().size(); ++i)
      if (std::ranges::count(columns, table.names()[i]) == 0) kept_.push_back(i);
    std::vector<std::string> names;
    for (const std::size_t i : kept_) names.push_back(csv_field(table.names()[i]));
    names.insert(names.end(), columns.begin(), columns.end());
    progress_.emplace("points", static_cast<int>(table.size()));
    text_ = fmt::format("{}\n", fmt::join(names, ","));
  }

  // All columns but the last, `valid`. What overflowed is no answer, nor could it be read again.
  void add(std::size_t row, const std::vector<double>& values) {
    if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) {
      overflowed_ = true;
      return add_invalid(row);
    }
    begin(row);
    for (const double value : values) text_ += fmt::format("{},", value);
    text_ += "1\n";
    ++num_valid_;
  }

  void add_invalid(std::size_t row) {
    begin(row);
    text_ += std::string(num_columns_ - 1, ',') + "0\n";
  }

  // Prints the table, or writes it to a file, and says how many points there are and how certain.
  void finish(const ProjectArguments& arguments, const char* invalid,
              const std::string& uncertainty) {
    progress_.reset();
    write_table(text_, arguments.out, arguments.json);
    if (arguments.json)
      print_result(
          json_text({{"uncertainty", uncertainty}, {"points", rows_json(text_, table_.texts())}}));
    const std::size_t others = table_.size() - num_valid_;
    print_note("{} of {} points{}\n", num_valid_, table_.size(),
               others == 0
                   ? ""
                   : fmt::format("; {} {}{} (valid = 0)", others, invalid,
                                 overflowed_ ? ", or are beyond the range of numbers" : ""));
    print_note("{}\n", uncertainty);
  }

  int exit_code() const { return num_valid_ == 0 && table_.size() > 0 ? kNoAnswer : kAnswer; }

 private:
  void begin(std::size_t row) {
    progress_->update(static_cast<int>(row));
    for (const std::size_t i : kept_) text_ += csv_field(table_.fields(row)[i]) + ",";
  }

  const PointTable& table_;
  std::vector<std::size_t> kept_;
  std::string text_;
  std::size_t num_columns_;
  std::size_t num_valid_ = 0;
  bool overflowed_ = false;
  std::optional<Progress> progress_;
};

// From the upper triangle, row by row. Throws Error unless it is a covariance.
template <typename Matrix>
Matrix covariance_of(const PointTable& table, std::size_t row,
                     const std::vector<std::size_t>& columns) {
  const std::vector<double> v = table.numbers(row, columns);
  Matrix m = Matrix::Zero();
  std::size_t next = 0;
  for (int i = 0; i < m.rows(); ++i)
    for (int j = i; j < m.cols(); ++j) m(i, j) = m(j, i) = v[next++];
  if (const std::string defect = covariance_defect(m); !defect.empty())
    table.fail(row, columns, "must be a covariance (which " + defect + ")");
  return m;
}

std::vector<double> triangle(const Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

void check_out(const ProjectArguments& arguments) {
  check_text_writable(arguments.out);
  check_replaces_nothing({arguments.out}, {arguments.camera, arguments.points});
}

int run_project(const ProjectArguments& arguments) {
  check_out(arguments);
  const LensInput input = read_lens(arguments.camera, arguments.view);
  const PointTable table = PointTable::read(arguments.points);
  const auto xyz = table.need({{"x_m", "y_m", "z_m"}, {"x", "y", "z"}});
  const auto spread = table.find({{"sxx_m2", "sxy_m2", "sxz_m2", "syy_m2", "syz_m2", "szz_m2"}});
  const Pose pose = input.camera_from_world.value_or(Pose());
  const Matrix3d turn = pose.rotation_matrix();
  Answer answer(table, {"u_px", "v_px", "suu_px2", "suv_px2", "svv_px2", "in_image", "valid"});
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (table.is_empty(row, xyz)) {
      answer.add_invalid(row);
      continue;
    }
    const std::vector<double> x = table.numbers(row, xyz);
    UncertainPoint point{pose * Vector3d(x[0], x[1], x[2]), Matrix3d::Zero()};
    if (!spread.empty() && !table.is_empty(row, spread))
      point.covariance = turn * covariance_of<Matrix3d>(table, row, spread) * turn.transpose();
    const auto at = project(input.camera, point);
    if (!at) {
      answer.add_invalid(row);
      continue;
    }
    const Matrix2& s = at->covariance_px2;
    answer.add(row, {at->pixel.x(), at->pixel.y(), s(0, 0), s(0, 1), s(1, 1),
                     contains(input.camera.camera.image_size, at->pixel) ? 1.0 : 0.0});
  }
  answer.finish(arguments, "outside the lens' domain", input.uncertainty);
  return answer.exit_code();
}

// What unproject makes of a pixel.
class Unprojection {
 public:
  Unprojection(const ProjectArguments& arguments, const LensInput& input, const PointTable& table)
      : arguments_(arguments),
        input_(input),
        depth_(table.find({{"depth_m"}})),
        sigma_depth_(table.find({{"sigma_depth_m"}})) {
    if (arguments.plane && (!depth_.empty() || arguments.depth_m > 0))
      throw Error("--plane: excludes --depth and the column depth_m");
    if (!depth_.empty() && arguments.depth_m > 0)
      throw Error("--depth: excludes the column depth_m");
  }

  bool gives_points() const {
    return arguments_.plane || arguments_.depth_m > 0 || !depth_.empty();
  }

  std::vector<std::string> columns() const {
    if (gives_points())
      return {"x_m",    "y_m",    "z_m",    "sxx_m2",   "sxy_m2", "sxz_m2",
              "syy_m2", "syz_m2", "szz_m2", "in_image", "valid"};
    return {"dx", "dy", "dz", "sxx", "sxy", "sxz", "syy", "syz", "szz", "in_image", "valid"};
  }

  // In the frame of the camera; with a view in that of the world.
  std::optional<UncertainPoint> of(const PointTable& table, std::size_t row,
                                   const UncertainPixel& pixel) const {
    if (arguments_.plane) return point_on_plane(input_.camera, pixel, *input_.camera_from_world);
    std::optional<UncertainPoint> point;
    if (gives_points()) {
      const double depth = depth_.empty() ? arguments_.depth_m : table.numbers(row, depth_)[0];
      const double sigma = sigma_depth_.empty() ? 0 : table.numbers(row, sigma_depth_)[0];
      if (!(sigma >= 0)) table.fail(row, sigma_depth_, "must be >= 0");
      point = point_at_depth(input_.camera, pixel, depth, sigma);
    } else {
      point = direction(input_.camera, pixel);
    }
    if (point && input_.camera_from_world) to_world(*point);
    return point;
  }

 private:
  void to_world(UncertainPoint& point) const {
    const Pose world_from_camera = input_.camera_from_world->inverse();
    const Matrix3d turn = world_from_camera.rotation_matrix();
    point.x = gives_points() ? world_from_camera * point.x : Vector3d(turn * point.x);
    point.covariance = turn * point.covariance * turn.transpose();
  }

  const ProjectArguments& arguments_;
  const LensInput& input_;
  std::vector<std::size_t> depth_, sigma_depth_;
};

int run_unproject(const ProjectArguments& arguments) {
  if (arguments.plane && arguments.view.empty())
    throw Error("--plane: needs --view, the picture in which the plane is seen");
  check_out(arguments);
  const LensInput input = read_lens(arguments.camera, arguments.view);
  const PointTable table = PointTable::read(arguments.points);
  const auto uv = table.need({{"u_px", "v_px"}, {"x_px", "y_px"}, {"u", "v"}});
  const auto spread =
      table.find({{"suu_px2", "suv_px2", "svv_px2"}, {"sxx_px2", "sxy_px2", "syy_px2"}});
  const Unprojection unprojection(arguments, input, table);
  Answer answer(table, unprojection.columns());
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (table.is_empty(row, uv)) {
      answer.add_invalid(row);
      continue;
    }
    const std::vector<double> u = table.numbers(row, uv);
    UncertainPixel pixel{{u[0], u[1]}, Matrix2::Zero()};
    if (!spread.empty() && !table.is_empty(row, spread))
      pixel.covariance_px2 = covariance_of<Matrix2>(table, row, spread);
    const auto point = unprojection.of(table, row, pixel);
    if (!point) {
      answer.add_invalid(row);
      continue;
    }
    std::vector<double> values = {point->x.x(), point->x.y(), point->x.z()};
    for (const double value : triangle(point->covariance)) values.push_back(value);
    values.push_back(contains(input.camera.camera.image_size, pixel.pixel) ? 1.0 : 0.0);
    answer.add(row, values);
  }
  answer.finish(arguments,
                arguments.plane ? "whose ray does not meet the plane"
                                : "have no ray, or none that points forward",
                input.uncertainty);
  return answer.exit_code();
}

void add_common(CLI::App& command, ProjectArguments& arguments, const char* points) {
  add_option(command, "POINTS.csv", arguments.points, points);
  add_option(command, "--camera", arguments.camera, "the camera's calibration")
      .text("C.yaml")
      .required();
  add_option(command, "--out", arguments.out, "file to write, instead of stdout")
      .text("CSV")
      .writes_text();
  add_flag(command, "--json", arguments.json, "one JSON object on stdout");
}

}  // namespace

Command add_project(CLI::App& app) {
  CLI::App* command = add_command(app, "project", "points to pixels, with covariances");
  const auto arguments = std::make_shared<ProjectArguments>();
  add_common(*command, *arguments,
             "CSV with x_m,y_m,z_m and perhaps sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2; other "
             "columns are kept; - or nothing: stdin");
  add_option(*command, "--view", arguments->view,
             "the points are in the world of this picture of the camera file, not in the camera "
             "frame")
      .text("NAME");
  add_footer(*command, "Example: tagcal project points.csv --camera camera.yaml --view 003.png");
  return {command, [arguments] { return run_project(*arguments); }};
}

Command add_unproject(CLI::App& app) {
  CLI::App* command =
      add_command(app, "unproject", "pixels to rays, or to points at a depth or on a plane");
  const auto arguments = std::make_shared<ProjectArguments>();
  add_common(*command, *arguments,
             "CSV with u_px,v_px (or x_px,y_px) and perhaps suu_px2,suv_px2,svv_px2 and "
             "depth_m,sigma_depth_m; other columns are kept; - or nothing: stdin");
  add_option(*command, "--view", arguments->view,
             "answer in the world of this picture of the camera file, not in the camera frame")
      .text("NAME");
  add_length(*command, "--depth", arguments->depth_m,
             "the points at this depth along the optical axis, metres");
  add_flag(*command, "--plane", arguments->plane,
           "the points on the plane z = 0 of the world (a board, a floor); needs --view");
  add_footer(*command,
             "Example: tagcal unproject pixels.csv --camera camera.yaml --plane --view 003.png");
  return {command, [arguments] { return run_unproject(*arguments); }};
}

}  // namespace tagcal::tools
