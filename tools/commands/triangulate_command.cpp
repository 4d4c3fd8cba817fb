// tagcal triangulate: pixels of the cameras of a rig to points.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
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
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/uncertainty/triangulate.hpp"

namespace tagcal::tools {
namespace {

struct TriangulateArguments {
  std::string points = "-";
  std::string camera;
  double sigma_px = 0.5;
  std::string out;
  bool json = false;
};

// The rows of one point, in the order of the file.
struct PointRows {
  std::string name;
  std::vector<SeenPixel> seen;
  std::size_t first_row = 0;
};

std::size_t camera_of(const KnownRig& rig, const PointTable& table, std::size_t row,
                      std::size_t column) {
  const std::string& name = table.fields(row)[column];
  const auto found = std::ranges::find(rig.cameras, name, &KnownRig::Member::name);
  if (found != rig.cameras.end()) return static_cast<std::size_t>(found - rig.cameras.begin());
  std::vector<std::string> names;
  for (const KnownRig::Member& member : rig.cameras) names.push_back(member.name);
  table.fail(row, {column},
             fmt::format("must be a camera of the rig ({})", fmt::join(names, ", ")));
}

std::vector<PointRows> read_points(const PointTable& table, const KnownRig& rig, double sigma_px) {
  const std::size_t point = table.need({{"point"}}).front();
  const std::size_t camera = table.need({{"camera"}}).front();
  const auto uv = table.need({{"u_px", "v_px"}, {"x_px", "y_px"}, {"u", "v"}});
  const auto spread =
      table.find({{"suu_px2", "suv_px2", "svv_px2"}, {"sxx_px2", "sxy_px2", "syy_px2"}});
  std::vector<PointRows> points;
  std::map<std::string, std::size_t> by_name;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const std::string& name = table.fields(row)[point];
    const auto [at, is_new] = by_name.emplace(name, points.size());
    if (is_new) points.push_back({name, {}, row});
    SeenPixel seen{camera_of(rig, table, row, camera), {}};
    if (table.is_empty(row, uv)) continue;
    PointRows& rows = points[at->second];
    if (std::ranges::count(rows.seen, seen.camera, &SeenPixel::camera) > 0)
      table.fail(row, {point, camera}, "must be given once");
    const std::vector<double> pixel = table.numbers(row, uv);
    seen.at.pixel = {pixel[0], pixel[1]};
    seen.at.covariance_px2 = sigma_px * sigma_px * Matrix2::Identity();
    if (!spread.empty() && !table.is_empty(row, spread)) {
      const std::vector<double> s = table.numbers(row, spread);
      seen.at.covariance_px2 << s[0], s[1], s[1], s[2];
      if (const std::string defect = covariance_defect(seen.at.covariance_px2); !defect.empty())
        table.fail(row, spread, "must be a covariance (which " + defect + ")");
    }
    rows.seen.push_back(seen);
  }
  return points;
}

constexpr const char* kHeader =
    "point,status,x_m,y_m,z_m,sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2,sigma_m,rms_px,cameras,"
    "chi_square,contradicts\n";

std::string row_of(const PointRows& rows, const TriangulatedPoint& found, const KnownRig& rig) {
  std::string text = fmt::format("{},{},", csv_field(rows.name), status_name(found.status));
  if (found.status == TriangulationStatus::ok) {
    const Eigen::Vector3d& x = found.point.x;
    const Eigen::Matrix3d& c = found.point.covariance;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},", x.x(), x.y(), x.z(), c(0, 0), c(0, 1),
                        c(0, 2), c(1, 1), c(1, 2), c(2, 2), std::sqrt(c.trace()));
  } else {
    text += std::string(10, ',');
  }
  std::vector<std::string> names;
  for (const std::size_t i : found.contradicting)
    names.push_back(rig.cameras[rows.seen[i].camera].name);
  if (found.residuals_px.empty()) return text + fmt::format(",{},,\n", rows.seen.size());
  return text + fmt::format("{},{},{},{}\n", found.rms_px, rows.seen.size(), found.chi_square,
                            csv_field(fmt::format("{}", fmt::join(names, " "))));
}

std::string plural(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

int run(const TriangulateArguments& arguments) {
  check_text_writable(arguments.out);
  check_replaces_nothing({arguments.out}, {arguments.camera, arguments.points});
  const CameraFile file = read_camera_file(arguments.camera);
  hold_notes(arguments.camera, file.notes);
  const KnownRig rig = known_rig(file, arguments.camera);
  const PointTable table = PointTable::read(arguments.points);
  std::string text = kHeader;
  std::array<std::size_t, 5> by_status = {};
  std::size_t num_contradicting = 0;
  const std::vector<PointRows> points = read_points(table, rig, arguments.sigma_px);
  for (const PointRows& rows : points) {
    const TriangulatedPoint found =
        naming(arguments.camera, [&] { return triangulate(rig, rows.seen); });
    ++by_status[static_cast<std::size_t>(found.status)];
    num_contradicting += !found.contradicting.empty();
    text += row_of(rows, found, rig);
  }
  write_table(text, arguments.out, arguments.json);
  const std::string uncertainty =
      rig.covariance.size() > 0
          ? "covariances: by the pixels, and by the places and lenses of the cameras"
          : "covariances: by the pixels alone: the rig's file has none of places and lenses";
  if (arguments.json)
    print_result(json_text({{"uncertainty", uncertainty},
                            {"points", rows_json(text, {"point", "status", "contradicts"})}}));
  const std::size_t num_valid = by_status[0];
  std::string others;
  for (std::size_t s = 1; s < by_status.size(); ++s)
    if (by_status[s] > 0)
      others +=
          fmt::format("; {} {}", by_status[s], status_name(static_cast<TriangulationStatus>(s)));
  print_note("{} of {}{}\n{}\n", num_valid, plural(points.size(), "point"), others, uncertainty);
  if (num_contradicting > 0)
    print_to_stderr(
        "tagcal: warning: the pixels of {} contradict one another: column contradicts names the "
        "cameras. A wrong match, pictures of different instants, or --sigma too small\n",
        plural(num_contradicting, "point"));
  return num_valid == 0 && !points.empty() ? kNoAnswer : kAnswer;
}

}  // namespace

Command add_triangulate(CLI::App& app) {
  CLI::App* command =
      add_command(app, "triangulate", "pixels of several cameras of a rig to points");
  const auto arguments = std::make_shared<TriangulateArguments>();
  add_option(*command, "POINTS.csv", arguments->points,
             "CSV with point,camera,u_px,v_px (or x_px,y_px; u,v), a row for each camera that sees "
             "the point, and perhaps suu_px2,suv_px2,svv_px2; - or nothing: stdin");
  add_option(*command, "--camera", arguments->camera, "the rig, as tagcal rig wrote it")
      .text("RIG.yaml")
      .required();
  add_positive(*command, "--sigma", arguments->sigma_px,
               "standard deviation of the pixels without covariances, px (0.5)");
  add_option(*command, "--out", arguments->out, "file to write, instead of stdout")
      .text("CSV")
      .writes_text();
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_footer(*command, "Example: tagcal triangulate pixels.csv --camera rig.yaml --out points.csv");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
