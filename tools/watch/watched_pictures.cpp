#include "watch/watched_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "job/digest.hpp"
#include "job/find_corners.hpp"
#include "job/progress.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kMostExplained = 3;  // pictures of one update: an explanation takes seconds

std::string wrong_size_text(const ImageSize& size, const ImageSize& others) {
  const bool turned = size.width == others.height && size.height == others.width;
  return fmt::format("{}x{} pixels{}, the others have {}x{}: one camera has one image size",
                     size.width, size.height, turned ? " (turned by 90 degrees)" : "", others.width,
                     others.height);
}

// A reader's message without the path that it begins with: the line begins with the name.
std::string without_path(const std::string& message, const fs::path& file) {
  const std::string start = file.string() + ": ";
  return message.starts_with(start) ? message.substr(start.size()) : message;
}

// The warnings that begin with the picture's name, without the name.
std::vector<std::string> warnings_of(const std::string& name,
                                     const std::vector<std::string>& warnings) {
  std::vector<std::string> own;
  const std::string start = name + ": ";
  for (const std::string& warning : warnings)
    if (warning.starts_with(start)) own.push_back(warning.substr(start.size()));
  return own;
}

constexpr double kDarkLevel = 25;     // numeric: of 255; a picture with so dark a bright part
constexpr double kBrightLevel = 250;  // numeric: and with so bright a dark part

// The grey levels below which 2 % and 98 % of the pixels are.
std::pair<double, double> dark_and_bright(const ImageView8& image) {
  std::array<std::size_t, 256> counts{};
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) ++counts[image.row(y)[x]];
  const double all = static_cast<double>(image.width()) * image.height();
  const auto level = [&](double share) {
    double below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i)
      if ((below += static_cast<double>(counts[i])) >= share * all) return static_cast<double>(i);
    return 255.0;
  };
  return {level(0.02), level(0.98)};  // numeric: shares of the pixels, see above
}

// The reason that most tags of the board have.
std::string commonest_reason(const std::vector<NotReported>& tags) {
  std::map<std::string, int> counts;
  for (const NotReported& tag : tags) ++counts[tag.why];
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  return most == counts.end() ? "" : most->first;
}

// Why a picture shows no board, in a few words. Costs about ten times as much as detection.
std::string why_no_board(const ImageView8& image, const std::vector<PlacedBoard>& boards) {
  const auto [dark, bright] = dark_and_bright(image);
  if (bright < kDarkLevel) return "the picture is almost black";
  if (dark > kBrightLevel) return "the picture is overexposed";
  const Explanation found = explain(image, boards);
  if (!found.mistakes.empty()) return found.mistakes.front();
  if (!found.checkerboards.empty()) return found.checkerboards.front();
  if (found.quads == 0) return "nothing in the picture looks like a tag";
  const std::string family = tag_kind(boards[0].board).value_or(TagKind{}).family;
  if (std::ranges::find(found.decoded, family, &SeenKind::family) == found.decoded.end())
    return fmt::format("{} black squares, but none can be read as a tag: too far, blurred or cut?",
                       found.quads);
  return fmt::format("tags are read, but {}", commonest_reason(found.not_reported));
}

std::string reason(const fs::path& file, const std::vector<PlacedBoard>& boards) {
  const Progress progress("explaining");
  try {
    return why_no_board(read_image(file), boards);
  } catch (const Error&) {
    return "the picture has gone meanwhile";
  }
}

}  // namespace

WatchedPictures::WatchedPictures(fs::path folder, Board board, Options options)
    : folder_(std::move(folder)), options_(std::move(options)) {
  boards_.push_back({std::move(board), {}});
  detection_.threads = options_.threads;
  detection_.skip_unreadable = true;
  if (!options_.cache.empty()) cache_.emplace(options_.cache, boards_, detection_);
}

std::vector<PictureNews> WatchedPictures::update(const PictureChanges& changes) {
  std::vector<PictureNews> news;
  std::vector<Search> unknown;
  std::set<std::string> searched;
  for (const std::string& name : changes.ready) {
    Search picture{name, digest_of_file(folder_ / name), {}, ""};
    if (auto told = known(picture, changes.removed)) {
      if (!told->other.empty()) news.push_back(std::move(*told));
      continue;
    }
    try {
      picture.size = read_image_size(folder_ / name);
    } catch (const Error& error) {
      picture.failure = without_path(error.what(), folder_ / name);
    }
    if (picture.failure.empty()) {
      unknown.push_back(std::move(picture));
    } else {
      news.push_back({name, Fate::unreadable, 0, "", picture.failure, {}});
    }
  }
  for (PictureNews& told : search(unknown)) news.push_back(std::move(told));
  for (const std::string& name : changes.removed)
    if (auto told = forget(name)) news.push_back(std::move(*told));
  if (!has_corners()) size_ = {};
  return news;
}

// News of a picture whose bytes are known: `other` is empty if its own name is too.
std::optional<PictureNews> WatchedPictures::known(const Search& picture, const Removed& removed) {
  const auto at = contents_.find(picture.digest);
  if (picture.digest.empty() || at == contents_.end()) return std::nullopt;
  Content& content = at->second;
  PictureNews told{picture.name, Fate::repeated, content.view.observations.size(), "", "", {}};
  if (content.names.contains(picture.name)) return told;
  forget(picture.name);
  told.other = content.view.image;
  content.names.insert(picture.name);
  digests_[picture.name] = picture.digest;
  if (std::ranges::count(removed, told.other) > 0) {
    told.fate = Fate::renamed;
    content.view.image = picture.name;
  }
  return told;
}

std::vector<DetectedPicture> WatchedPictures::detect(const std::vector<Search>& pictures) {
  std::vector<ImageSource> images;
  for (const Search& picture : pictures)
    images.push_back({picture.name, [this, file = folder_ / picture.name] {
                        if (options_.is_interrupted()) throw Error("interrupted");
                        return read_image(file);
                      }});
  EarlierResults earlier;
  if (cache_) {
    earlier.find = [&](std::size_t i, std::size_t) {
      return cache_->find(pictures[i].name, folder_ / pictures[i].name);
    };
    earlier.keep = [&](std::size_t i, const DetectedPicture& found) {
      cache_->keep(pictures[i].name, found);
    };
  }
  DetectOptions options = detection_;
  if (cache_) options.earlier = &earlier;
  Progress progress("detecting", static_cast<int>(pictures.size()));
  std::vector<DetectedPicture> found =
      detect_all(images, boards_, options, [&](int done, int) { progress.update(done); });
  const std::vector<TargetMistake> mistakes = target_mistakes(images, found, boards_, options);
  mistake_ = tools::wrong_target(mistakes);
  const std::vector<std::string> warnings = board_warnings(boards_, mistakes);
  general_.insert(warnings.begin(), warnings.end());
  return found;
}

// The size that most pictures with corners have, if none is known yet.
void WatchedPictures::find_size(const std::vector<Search>& pictures,
                                const std::vector<DetectedPicture>& found) {
  if (size_.width > 0) return;
  std::map<std::pair<int, int>, int> counts;
  int most = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (found[i].view.observations.empty()) continue;
    const ImageSize& size = pictures[i].size;
    if (++counts[{size.width, size.height}] <= most) continue;
    most = counts[{size.width, size.height}];
    size_ = size;
  }
}

std::vector<PictureNews> WatchedPictures::search(const std::vector<Search>& pictures) {
  std::vector<PictureNews> news;
  if (pictures.empty()) return news;
  std::vector<DetectedPicture> found = detect(pictures);
  find_size(pictures, found);
  int explained = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Search& picture = pictures[i];
    DetectedPicture& seen = found[i];
    if (!seen.unreadable.empty()) {
      news.push_back({picture.name,
                      Fate::unreadable,
                      0,
                      "",
                      without_path(seen.unreadable, folder_ / picture.name),
                      {}});
      continue;
    }
    std::vector<std::string> warnings = warnings_of(picture.name, seen.warnings);
    PictureNews told = keep(picture, std::move(seen.view), std::move(warnings));
    if (told.fate == Fate::no_board && explained++ < kMostExplained)
      told.why = reason(folder_ / picture.name, boards_);
    news.push_back(std::move(told));
  }
  return news;
}

PictureNews WatchedPictures::keep(const Search& picture, View view,
                                  std::vector<std::string> warnings) {
  forget(picture.name);  // it was written again
  PictureNews told{picture.name, Fate::board_found, view.observations.size(), "", "", warnings};
  if (view.observations.empty()) {
    told.fate = Fate::no_board;
    if (!warnings.empty()) told.why = warnings.back();
    told.warnings.clear();
  } else if (picture.size != size_) {
    told.fate = Fate::wrong_size;
    told.why = wrong_size_text(picture.size, size_);
    return told;
  }
  Content& content = contents_[picture.digest];
  content.names.insert(picture.name);
  if (content.view.image.empty()) {
    content.view = std::move(view);
    content.mistake = mistake_;
    if (told.num_corners > 0) ++revision_;
  }
  content.size = picture.size;
  content.warnings = std::move(warnings);
  digests_[picture.name] = picture.digest;
  if (content.view.image != picture.name) {  // twice within one update
    told.fate = Fate::repeated;
    told.other = content.view.image;
  }
  return told;
}

// News if a picture goes with its last name.
std::optional<PictureNews> WatchedPictures::forget(const std::string& name) {
  const auto at = digests_.find(name);
  if (at == digests_.end()) return std::nullopt;
  const std::string digest = at->second;
  digests_.erase(at);
  Content& content = contents_.at(digest);
  content.names.erase(name);
  if (!content.names.empty()) {
    if (content.view.image == name) content.view.image = *content.names.begin();
    return std::nullopt;
  }
  PictureNews told{name, Fate::removed, content.view.observations.size(), "", "", {}};
  if (told.num_corners > 0) ++revision_;
  contents_.erase(digest);
  return told;
}

bool WatchedPictures::has_corners() const {
  return std::ranges::any_of(
      contents_, [](const auto& entry) { return !entry.second.view.observations.empty(); });
}

std::optional<Finding> WatchedPictures::wrong_target() const {
  std::optional<Finding> found;
  int wrong = 0, all = 0;
  for (const auto& [digest, content] : contents_) {
    if (content.view.observations.empty()) continue;
    ++all;
    if (!content.mistake) continue;
    ++wrong;
    found = content.mistake;
  }
  return 2 * wrong > all ? found : std::nullopt;
}

Dataset WatchedPictures::dataset() const {
  Dataset dataset;
  dataset.image_size = size_;
  dataset.boards = boards_;
  for (const auto& [digest, content] : contents_)
    if (!content.view.observations.empty()) dataset.views.push_back(content.view);
  std::ranges::sort(dataset.views, {}, &View::image);
  return dataset;
}

std::vector<std::string> WatchedPictures::warnings() const {
  std::vector<std::string> all(general_.begin(), general_.end());
  std::vector<const Content*> contents;
  for (const auto& [digest, content] : contents_)
    if (!content.view.observations.empty()) contents.push_back(&content);
  std::ranges::sort(contents, {}, [](const Content* c) { return c->view.image; });
  for (const Content* content : contents)
    for (const std::string& warning : content->warnings)
      all.push_back(content->view.image + ": " + warning);
  return all;
}

bool WatchedPictures::save_cache() { return cache_ && cache_->save(); }

}  // namespace tagcal::tools
