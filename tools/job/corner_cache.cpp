#include "job/corner_cache.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "job/digest.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kFirstWords = "tagcal corner cache 1 ";

// The program that finds the corners: its version, and where the system shows it, the date of its
// build, because a development build changes without its version.
std::string program_text() {
  std::error_code error;
  const auto built = fs::last_write_time("/proc/self/exe", error);
  return fmt::format("tagcal {} {}", TAGCAL_VERSION,
                     error ? 0 : std::int64_t{built.time_since_epoch().count()});
}

std::string key_of(const std::vector<PlacedBoard>& boards, const DetectOptions& options) {
  std::string text = fmt::format("{}\nrefinement {}\nmax_hamming {}\n", program_text(),
                                 static_cast<int>(options.refinement), options.max_hamming);
  if (options.camera) {
    const Lens& lens = options.camera->lens;
    text += fmt::format("camera {} {}x{}", lens.index(), options.camera->image_size.width,
                        options.camera->image_size.height);
    for (const double value : parameters(lens)) text += fmt::format(" {}", value);
    text += '\n';
  }
  for (const PlacedBoard& placed : boards) {
    const Eigen::Quaterniond q = placed.world_from_board.rotation();
    const Eigen::Vector3d& t = placed.world_from_board.translation();
    text += fmt::format("{}pose {} {} {} {} {} {} {}\n", target_yaml(placed.board), q.w(), q.x(),
                        q.y(), q.z(), t.x(), t.y(), t.z());
  }
  return digest_of(text);
}

// The picture's name is left out.
Json json_of(const DetectedPicture& found) {
  Json corners = Json::array(), unfitted = Json::array();
  for (const Observation& seen : found.view.observations) {
    Json corner = {seen.id.tag_id, seen.id.corner, seen.pixel.x(), seen.pixel.y()};
    if (const auto& c = seen.covariance_px2)
      for (const double value : {(*c)(0, 0), (*c)(0, 1), (*c)(1, 0), (*c)(1, 1)})
        corner.push_back(value);
    corners.push_back(std::move(corner));
  }
  for (const UnfittedTag& tag : found.unfitted) {
    Json values = {tag.id};
    for (const Eigen::Vector2d& corner : tag.corners) {
      values.push_back(corner.x());
      values.push_back(corner.y());
    }
    unfitted.push_back(std::move(values));
  }
  return {{"corners", corners},
          {"unfitted", unfitted},
          {"warnings", found.warnings},
          {"size", {found.size.width, found.size.height}},
          {"sure", found.num_sure},
          {"unread", found.num_unread},
          {"strange", found.has_strange_tags}};
}

DetectedPicture found_of(const Json& json, const std::string& name) {
  DetectedPicture found;
  found.view.image = name;
  for (const Json& corner : json.at("corners")) {
    Observation seen{{corner.at(0), corner.at(1)}, Eigen::Vector2d::Zero(), {}};
    seen.pixel = Eigen::Vector2d(corner.at(2).get<double>(), corner.at(3).get<double>());
    if (corner.size() > 4) {
      Matrix2 covariance;
      for (int i = 0; i < 4; ++i)
        covariance(i / 2, i % 2) = corner.at(4 + static_cast<std::size_t>(i)).get<double>();
      seen.covariance_px2 = covariance;
    }
    found.view.observations.push_back(seen);
  }
  for (const Json& values : json.at("unfitted")) {
    UnfittedTag tag{values.at(0), {}};
    for (std::size_t i = 0; i < 4; ++i)
      tag.corners[i] =
          Eigen::Vector2d(values.at(1 + 2 * i).get<double>(), values.at(2 + 2 * i).get<double>());
    found.unfitted.push_back(tag);
  }
  found.warnings = json.at("warnings").get<std::vector<std::string>>();
  found.size = {json.at("size").at(0), json.at("size").at(1)};
  found.num_sure = json.at("sure");
  found.num_unread = json.at("unread");
  found.has_strange_tags = json.at("strange");
  return found;
}

// False for a name that is not UTF-8, also in a warning: replaced, two names could become one.
bool can_be_written(const Json& picture) {
  try {
    picture.dump();
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

}  // namespace

CornerCache::CornerCache(fs::path file, const std::vector<PlacedBoard>& boards,
                         const DetectOptions& options)
    : file_(std::move(file)), key_(key_of(boards, options)) {
  std::error_code unknown;
  if (!fs::is_regular_file(file_, unknown)) return;
  try {
    read();
  } catch (const std::exception&) {  // of JSON or of reading
    entries_.clear();
    warning_ = fmt::format("{}: is damaged, the corners are detected again", file_.string());
  }
}

// The first line has a digest of the rest.
void CornerCache::read() {
  const std::string text = read_text(file_);
  const std::size_t end = text.find('\n');
  if (!text.starts_with(kFirstWords) || end == std::string::npos) throw Error("damaged");
  const std::string_view rest = std::string_view(text).substr(end + 1);
  if (text.substr(0, end) != kFirstWords + digest_of(rest)) throw Error("damaged");
  const Json json = Json::parse(rest);
  if (json.at("key") != key_) return;
  for (const auto& [name, entry] : json.at("pictures").items())
    entries_[name] = {entry.at("content"), found_of(entry, name)};
}

std::optional<DetectedPicture> CornerCache::find(const std::string& name, const fs::path& picture,
                                                 const std::string& others) {
  std::string content = digest_of_file(picture);
  if (!content.empty() && !others.empty()) content += " after " + digest_of(others);
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[name];
  if (!content.empty() && entry.content == content && entry.found) {
    ++num_reused_;
    return entry.found;
  }
  entry = {std::move(content), {}};
  return std::nullopt;
}

void CornerCache::keep(const std::string& name, const DetectedPicture& found) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[name];
  if (entry.found) --num_reused_;  // it is known, but a frame before it is not
  entry.found = found;
  changed_ = true;
}

bool CornerCache::save() {
  if (!changed_) return false;
  Json pictures = Json::object();
  for (const auto& [name, entry] : entries_) {
    if (!entry.found || entry.content.empty()) continue;
    Json json = json_of(*entry.found);
    json["content"] = entry.content;
    if (can_be_written({name, json})) pictures[name] = std::move(json);
  }
  try {
    const std::string rest =
        Json({{"key", key_}, {"pictures", pictures}}).dump(-1, ' ', true) + "\n";
    write_whole(file_, kFirstWords + digest_of(rest) + "\n" + rest);
    return true;
  } catch (const std::exception& error) {
    warning_ = fmt::format("the corners are not kept for the next run: {}", error.what());
    return false;
  }
}

}  // namespace tagcal::tools
