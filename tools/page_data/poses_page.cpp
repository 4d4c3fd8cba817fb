#include "page_data/pages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "page_data/page_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

constexpr int kMostListed = 1'000'000;

// A view of tagcal pose --json, as far as the page shows it.
struct ReadView {
  std::string image;
  std::optional<Pose> camera_from_board;  // the likelier of two
  std::set<CornerId> outliers;
  PageJson json;  // as the page has it
};

bool is_given(const std::optional<YamlValue>& value) {
  return value && (value->is_map() || value->is_list() || value->is_scalar());
}

// Null stands for a value that the answer does not have.
PageJson number_or_null(const YamlValue& map, std::string_view key, double most) {
  const auto value = map.find(key);
  return is_given(value) ? PageJson(value->number_in(0, most)) : PageJson();
}

std::string one_of(const YamlValue& value, const std::vector<std::string_view>& names) {
  if (value.is_scalar() && std::ranges::count(names, value.text()) > 0) return value.text();
  value.fail(fmt::format("must be {}", fmt::join(names, ", ")));
}

std::string read_status(const YamlValue& value) {
  std::vector<std::string_view> names;
  for (int i = 0; i <= static_cast<int>(Status::not_converged); ++i)
    names.push_back(status_name(static_cast<Status>(i)));
  return one_of(value, names);
}

// A file of tagcal pose has both parts of a pose, other than those that read_pose takes.
Pose read_whole_pose(const YamlValue& value) {
  for (const char* const key : {"rotation", "translation_m"}) value.at(key);
  return read_pose(value);
}

PageJson hypothesis_json(const YamlValue& view) {
  const double any = std::numeric_limits<double>::max();
  return {{"camera_from_world", matrix_json(read_whole_pose(view.at("camera_from_board")))},
          {"probability", number_or_null(view, "probability", 1)},
          {"rms_px", number_or_null(view, "rms_px", any)}};
}

PageJson read_findings(const YamlValue& view) {
  PageJson findings = PageJson::array();
  const auto given = view.find("findings");
  if (!is_given(given)) return findings;
  for (const YamlValue& finding : given->items(0, kMostListed)) {
    const std::string severity = one_of(
        finding.at("severity"), {severity_name(Severity::note), severity_name(Severity::warning),
                                 severity_name(Severity::refusal)});
    findings.push_back(
        {{"code", finding.at("code").text()},
         {"severity", severity == severity_name(Severity::refusal) ? "error" : severity},
         {"sentence", finding.at("sentence").text()}});
  }
  return findings;
}

std::set<CornerId> read_outliers(const YamlValue& view) {
  std::set<CornerId> outliers;
  const auto given = view.find("outliers");
  if (!is_given(given)) return outliers;
  const int most = std::numeric_limits<int>::max();
  for (const YamlValue& corner : given->items(0, kMostListed))
    outliers.insert({corner.at("tag_id").whole(0, most), corner.at("corner").whole(0, most)});
  return outliers;
}

ReadView read_view(const YamlValue& view) {
  ReadView read{view.at("image").text(), {}, read_outliers(view), {}};
  PageJson hypotheses = PageJson::array();
  if (const auto pose = view.find("camera_from_board"); is_given(pose)) {
    read.camera_from_board = read_whole_pose(*pose);
    hypotheses.push_back(hypothesis_json(view));
    const auto other = view.find("alternative");
    if (is_given(other)) hypotheses.push_back(hypothesis_json(*other));
  }
  const auto num_corners = view.find("num_corners");
  read.json = {
      {"image", read.image},
      {"time_s", number_or_null(view, "time_s", std::numeric_limits<double>::max())},
      {"status", read_status(view.at("status"))},
      {"num_corners",
       is_given(num_corners) ? PageJson(num_corners->whole(0, kMostListed)) : PageJson()},
      {"num_rejected", read.outliers.size()},
      {"rms_px", hypotheses.empty() ? PageJson() : hypotheses[0]["rms_px"]},
      {"max_px", nullptr},
      {"camera_from_world", hypotheses.empty() ? PageJson() : hypotheses[0]["camera_from_world"]},
      {"findings", read_findings(view)},
      {"hypotheses", std::move(hypotheses)}};
  return read;
}

std::vector<ReadView> read_views(const std::filesystem::path& file) {
  std::vector<ReadView> views;
  const YamlValue top = YamlValue::read(file);
  for (const YamlValue& view : top.at("views").items(0, kMostListed))
    views.push_back(read_view(view));
  return views;
}

// The content whose views are those of the file, in its order.
PageContent content_of(const PosesPageInput& given, const std::vector<ReadView>& views) {
  PageContent content;
  Input& input = *given.input;
  content.dataset.image_size = input.dataset.image_size;
  content.dataset.boards = input.dataset.boards;
  // Poses of a single board are in its frame (tagcal pose), those of several in the world's.
  if (content.dataset.boards.size() == 1) content.dataset.boards.front().world_from_board = Pose();
  content.pictures = input.files;
  Calibration& calibration = content.calibration;
  if (!given.camera.empty()) {
    calibration.camera = read_camera(given.camera).camera;
    check_image_size(calibration.camera->image_size, given.camera, input);
    calibration.status = Status::ok;
  }
  find_views(input, given.threads, true, calibration.camera ? &*calibration.camera : nullptr);
  print_warnings(input.warnings);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string& name = views[i].image;
    const auto found = std::ranges::find(input.dataset.views, name, &View::image);
    content.dataset.views.push_back(found == input.dataset.views.end() ? View{name, {}} : *found);
    if (views[i].camera_from_board) {
      CalibratedView estimate;
      estimate.view = i;
      estimate.camera_from_world = *views[i].camera_from_board;
      calibration.views.push_back(estimate);
    }
    const auto& seen = content.dataset.views.back().observations;
    for (std::size_t k = 0; k < seen.size(); ++k)
      if (views[i].outliers.contains(seen[k].id))
        calibration.outliers.push_back({name, seen[k].id, 0, i, k});
  }
  return content;
}

void add_data(const PosesPageInput& given, const std::vector<ReadView>& views, PageJson& page,
              std::vector<std::string>& notes) {
  const PageContent content = content_of(given, views);
  const std::vector<PageCorner> corners = page_corners(content);
  std::vector<std::string> names;
  for (const View& view : content.dataset.views) names.push_back(view.image);
  const auto pictures =
      thumbnails(picture_files_of(content), content.dataset.image_size, given.threads);
  for (std::size_t i = 0; i < pictures.size(); ++i) add_thumbnail(page["views"][i], pictures[i]);
  note_missing(names, pictures, notes);
  page["image_size"] = {content.dataset.image_size.width, content.dataset.image_size.height};
  page["corners"] = corners_json(corners);
  page["boards"] = boards_json(content.dataset.boards);
  if (given.camera.empty())
    notes.emplace_back("Residuals are not shown, because no camera was given: --camera CAMERA.");
}

PageJson verdict_of_views(const PageJson& views) {
  const auto with = [&](std::string_view status) {
    return std::ranges::count_if(views, [&](const PageJson& v) { return v["status"] == status; });
  };
  const auto ok = with("ok"), ambiguous = with("ambiguous");
  const std::string sentence =
      fmt::format("{} of {} views have a pose{}", ok + ambiguous, views.size(),
                  ambiguous > 0 ? fmt::format(", {} of them two", ambiguous) : "");
  const char* const level = ok + ambiguous == 0                              ? "no_answer"
                            : ambiguous > 0                                  ? "ambiguous"
                            : ok < static_cast<std::ptrdiff_t>(views.size()) ? "warnings"
                                                                             : "ok";
  return {{"level", level}, {"sentence", sentence}};
}

}  // namespace

bool is_poses_file(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return false;
  const std::string text = read_text(file);
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos || text[start] != '{') return false;
  try {
    const YamlValue top = YamlValue::parse(text, file.string());
    const auto views = top.find("views");
    return views && views->is_list() && !top.find("camera") && !top.find("model");
  } catch (const Error&) {
    return false;
  }
}

PageJson poses_page(const PosesPageInput& given) {
  const std::vector<ReadView> read = read_views(given.poses);
  PageJson views = PageJson::array();
  for (const ReadView& view : read) views.push_back(view.json);
  std::vector<std::string> notes;
  PageJson page = {{"format", 1},
                   {"kind", "poses"},
                   {"title", given.poses.filename().string()},
                   {"verdict", verdict_of_views(views)},
                   {"made_by", made_by_json()},
                   {"findings", PageJson::array()},
                   {"views", std::move(views)}};
  if (given.input)
    add_data(given, read, page, notes);
  else
    notes.emplace_back(
        "Pictures, corners and boards are not shown, because no data set was given: --dataset D, "
        "or --target T.yaml and the pictures.");
  page["notes"] = notes;
  return page;
}

}  // namespace tagcal::tools
