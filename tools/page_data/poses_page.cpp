#include "page_data/poses_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "input/camera_input.hpp"
#include "page_data/board_data.hpp"
#include "page_data/page_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/text/text_file.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

Pose read_pose(const PageJson& json) {
  const auto q = json.at("rotation").get<std::vector<double>>();
  const auto t = json.at("translation_m").get<std::vector<double>>();
  if (q.size() != 4 || t.size() != 3) throw Error("a pose must have 4 and 3 numbers");
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
}

PageJson hypothesis_json(const PageJson& view) {
  return {{"camera_from_world", matrix_json(read_pose(view.at("camera_from_board")))},
          {"probability", view.value("probability", PageJson())},
          {"rms_px", view.value("rms_px", PageJson())}};
}

PageJson read_findings(const PageJson& view) {
  PageJson findings = view.value("findings", PageJson::array());
  for (PageJson& finding : findings)
    if (finding.value("severity", "") == "refusal") finding["severity"] = "error";
  return findings;
}

PageJson view_json(const PageJson& view) {
  const bool has_pose = view.contains("camera_from_board") && !view["camera_from_board"].is_null();
  PageJson hypotheses = PageJson::array();
  if (has_pose) hypotheses.push_back(hypothesis_json(view));
  if (has_pose && view.contains("alternative") && !view["alternative"].is_null())
    hypotheses.push_back(hypothesis_json(view["alternative"]));
  const PageJson outliers = view.value("outliers", PageJson::array());
  return {{"image", view.at("image").get<std::string>()},
          {"status", view.at("status").get<std::string>()},
          {"num_corners", view.value("num_corners", PageJson())},
          {"num_rejected", outliers.size()},
          {"rms_px", view.value("rms_px", PageJson())},
          {"max_px", nullptr},
          {"camera_from_world", has_pose ? hypotheses[0]["camera_from_world"] : PageJson()},
          {"findings", read_findings(view)},
          {"hypotheses", std::move(hypotheses)}};
}

PageJson read_json(const std::filesystem::path& file) {
  try {
    return PageJson::parse(read_text(file));
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("{}: {}", file.string(), error.what()));
  }
}

// The content whose views are those of the file, in its order.
PageContent content_of(const PosesPageInput& given, const PageJson& file, const PageJson& views) {
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
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string name = views[i]["image"];
    const auto found = std::ranges::find(input.dataset.views, name, &View::image);
    content.dataset.views.push_back(found == input.dataset.views.end() ? View{name, {}} : *found);
    const PageJson& read = file["views"][i];
    if (!views[i]["camera_from_world"].is_null()) {
      CalibratedView estimate;
      estimate.view = i;
      estimate.camera_from_world = read_pose(read["camera_from_board"]);
      calibration.views.push_back(estimate);
    }
    std::set<CornerId> outliers;
    for (const PageJson& o : read.value("outliers", PageJson::array()))
      outliers.insert({o.at("tag_id"), o.at("corner")});
    const auto& seen = content.dataset.views.back().observations;
    for (std::size_t k = 0; k < seen.size(); ++k)
      if (outliers.contains(seen[k].id))
        calibration.outliers.push_back({name, seen[k].id, 0, i, k});
  }
  return content;
}

void add_data(const PosesPageInput& given, const PageJson& file, PageJson& page,
              std::vector<std::string>& notes) {
  const PageContent content = content_of(given, file, page["views"]);
  const std::vector<PageCorner> corners = page_corners(content);
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;
  for (const View& view : content.dataset.views) {
    const auto found = content.pictures.find(view.image);
    files.push_back(found == content.pictures.end() ? "" : found->second);
    names.push_back(view.image);
  }
  const auto pictures = thumbnails(files, content.dataset.image_size, given.threads);
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

PageJson page_of(const PosesPageInput& given, const PageJson& file) {
  PageJson views = PageJson::array();
  for (const PageJson& view : file.at("views")) views.push_back(view_json(view));
  std::vector<std::string> notes;
  PageJson page = {{"format", 1},
                   {"kind", "poses"},
                   {"title", given.poses.filename().string()},
                   {"verdict", verdict_of_views(views)},
                   {"made_by", made_by_json()},
                   {"findings", PageJson::array()},
                   {"views", std::move(views)}};
  if (given.input)
    add_data(given, file, page, notes);
  else
    notes.emplace_back(
        "Pictures, corners and boards are not shown, because no data set was given: --dataset D, "
        "or --target T.yaml and the pictures.");
  page["notes"] = notes;
  return page;
}

}  // namespace

bool is_poses_file(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return false;
  const std::string text = read_text(file);
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos || text[start] != '{') return false;
  const PageJson json = PageJson::parse(text, nullptr, false);
  return json.is_object() && json.contains("views") && json["views"].is_array() &&
         !json.contains("camera") && !json.contains("model");
}

PageJson poses_page(const PosesPageInput& given) {
  const PageJson file = read_json(given.poses);
  try {
    return page_of(given, file);
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("{}: is not an answer of tagcal pose --json: {}", given.poses.string(),
                            error.what()));
  }
}

}  // namespace tagcal::tools
