#include "commands/detect_tags_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "draw/tag_drawing.hpp"
#include "job/camera_input.hpp"
#include "job/command.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "job/progress.hpp"
#include "report/detection_report.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/corners_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using TagsOfPictures = std::vector<std::vector<DetectedTag>>;

// The tags of each picture of the input. Damaged pictures are left out of both.
TagsOfPictures find_tags(const TagSearch& search, Input& input, const Camera* camera) {
  DetectOptions options;
  options.threads = search.threads;
  options.refinement = input.refinement.value_or(options.refinement);
  options.camera = camera;
  options.skip_unreadable = !input.strict;
  std::optional<Progress> progress;
  progress.emplace("detecting", static_cast<int>(input.images.size()));
  std::vector<PictureTags> found =
      detect_all_tags(input.images, {search.input.family, search.border_bits}, options,
                      [&](int done, int) { progress->update(done); });
  progress.reset();
  TagsOfPictures tags;
  std::vector<std::string> unreadable;
  for (PictureTags& picture : found) {
    if (picture.unreadable.empty()) tags.push_back(std::move(picture.tags));
    unreadable.push_back(std::move(picture.unreadable));
  }
  leave_out_unreadable(input, unreadable);
  return tags;
}

View view_of(const DetectedTag& tag, const std::string& name) {
  View view{name, {}};
  for (int corner = 0; corner < 4; ++corner) {
    Observation seen{{tag.id, corner}, tag.corners[static_cast<std::size_t>(corner)], {}};
    if (tag.covariance_px2)
      seen.covariance_px2 = tag.covariance_px2->block<2, 2>(2 * corner, 2 * corner);
    view.observations.push_back(seen);
  }
  return view;
}

}  // namespace

std::string other_kind_text(const Input& input) {
  if (input.images.empty()) return "";
  // Half a picture's size is enough to read tags of 20 px, in a quarter of the time.
  const Image8 picture = input.images.front().load();
  const Explanation found = explain(internal::halved(picture), {});
  const auto most =
      std::ranges::max_element(found.decoded, {}, [](const auto& kind) { return kind.ids.size(); });
  if (most == found.decoded.end() || most->ids.size() < 2) return "";  // one is read by chance
  return fmt::format("what to do {} shows {} tags of another kind: --family {} --border-bits {}\n",
                     input.images.front().name, most->ids.size(), most->family, most->border_bits);
}

void draw_pictures(const Input& input, const std::string& to, OutputFolder& folder,
                   const std::function<ImageRgb(std::size_t picture)>& draw) {
  const std::vector<std::string> names = drawing_names(input, to);
  {
    Progress progress("drawing", static_cast<int>(input.images.size()));
    for (std::size_t i = 0; i < input.images.size(); ++i) {
      progress.update(static_cast<int>(i));
      write_png(folder.path() / names[i], draw(i));
    }
    folder.publish();
  }
  say_wrote(to);
}

std::vector<std::string> drawing_names(const Input& input, const std::string& folder) {
  std::vector<std::string> names;
  std::vector<std::filesystem::path> drawings, pictures;
  std::set<std::string> taken;
  for (const ImageSource& image : input.images) {
    names.push_back(std::filesystem::path(image.name).stem().string() + ".png");
    if (!taken.insert(names.back()).second)
      throw Error(fmt::format("--draw: two pictures would be drawn as {}", names.back()));
    drawings.push_back(std::filesystem::path(folder) / names.back());
  }
  for (const auto& [name, file] : input.files) pictures.push_back(file);
  check_replaces_nothing(drawings, pictures);
  return names;
}

std::optional<Camera> known_camera(const std::string& file, const Input& input) {
  if (file.empty()) return std::nullopt;
  const CalibrationFile read = read_camera(file);
  check_image_size(read.camera.image_size, file, input);
  return read.camera;
}

void find_views_of_tags(const TagSearch& search, Input& input, const Camera* camera) {
  if (const auto warning = wide_warning("--tag-size: a tag", search.input.tag_size_m))
    input.warnings.push_back(*warning);
  const TagsOfPictures tags = find_tags(search, input, camera);
  std::set<int> ids;
  std::vector<ImageSource> pictures;  // for drawings, by the name of the view
  for (std::size_t i = 0; i < tags.size(); ++i) {
    std::map<int, int> times;
    for (const DetectedTag& tag : tags[i]) {
      const int count = ++times[tag.id];
      const std::string name = fmt::format("{} tag {}{}", input.images[i].name, tag.id,
                                           count > 1 ? fmt::format(" ({})", count) : "");
      input.dataset.views.push_back(view_of(tag, name));
      pictures.push_back({name, input.images[i].load});
      if (const auto time = time_of(input, input.images[i].name)) input.times_s[name] = *time;
      ids.insert(tag.id);
    }
  }
  for (const int id : ids) {
    const Tags tag{
        search.input.family, search.border_bits, {{id, search.input.tag_size_m, Pose()}}};
    input.dataset.boards.push_back({make_board(tag), Pose()});
  }
  if (!ids.empty()) input.images = std::move(pictures);
}

int run_tag_search(const TagSearch& search) {
  check_text_writable(search.out);
  check_replaces_nothing({search.out}, {search.camera});
  InputArguments arguments = search.input;
  arguments.other_outputs = {search.out};
  Input input = read_input(arguments);
  const std::optional<Camera> camera = known_camera(search.camera, input);
  std::optional<OutputFolder> drawings;
  if (!search.draw.empty()) {
    drawing_names(input, search.draw);  // throws before the work
    drawings.emplace(search.draw, OutputFolder::Taken::by_any_folder);
  }
  const TagsOfPictures tags = find_tags(search, input, camera ? &*camera : nullptr);
  std::vector<std::string> names;
  std::vector<std::size_t> num_tags;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    names.push_back(input.images[i].name);
    num_tags.push_back(tags[i].size());
  }
  const std::string csv = tags_csv(names, tags);
  write_table(csv, search.out, search.json);
  if (drawings)
    draw_pictures(input, search.draw, *drawings,
                  [&](std::size_t i) { return draw_tags(input.images[i].load(), tags[i]); });
  print_warnings(input.warnings);
  const bool is_nothing = std::ranges::all_of(num_tags, [](std::size_t n) { return n == 0; });
  if (search.json) {
    print_result(json_text(tags_json(names, num_tags, input, rows_json(csv, {"image"}))));
    return kAnswer;
  }
  print_summary(tag_summary(names, num_tags, search.input.family, search.verbose) +
                    (is_nothing ? other_kind_text(input) : ""),
                search.out);
  return kAnswer;
}

}  // namespace tagcal::tools
