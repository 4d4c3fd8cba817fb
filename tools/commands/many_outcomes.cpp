#include "commands/many_outcomes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// For a later run, whose time is another.
std::string without_seconds(const std::string& answer) {
  Json json = Json::parse(answer, nullptr, false);
  if (!json.is_object()) return answer;
  json.erase("seconds");
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// What else a user may have meant.
constexpr const char* kOneCamera =
    " (with --target and --one-camera all pictures are one camera's)";

bool has_camera_name(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".yaml" || ending == ".yml" || ending == ".json";
}

std::string without_ending(fs::path file) {
  return has_camera_name(file) ? file.replace_extension().string() : "cameras";
}

}  // namespace

AnswerFolder::AnswerFolder(fs::path folder, bool shared) : folder_(std::move(folder)) {
  if (folder_.empty()) return;
  const bool is_folder = fs::is_directory(folder_);
  if (!is_folder && (fs::exists(folder_) || has_camera_name(folder_)))
    throw Error(
        fmt::format("--out: {} must be a folder, because each folder of the call is a "
                    "camera with a file of its own: --out {}{}",
                    folder_.string(), without_ending(folder_), kOneCamera));
  std::error_code why;
  is_new_ = fs::create_directories(folder_, why);
  if (why) throw Error(fmt::format("{}: cannot be written: {}", folder_.string(), why.message()));
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (::flock(lock_, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(lock_);
    throw Error(fmt::format("{}: another process is writing it{}", folder_.string(),
                            shared ? "" : " (with --resume both can)"));
  }
}

AnswerFolder::~AnswerFolder() {
  if (lock_ >= 0) ::close(lock_);
  std::error_code not_empty;
  if (is_new_) fs::remove(folder_, not_empty);
}

// One byte of one file stands for each name; two names with the same one only wait for each other.
SetLock::SetLock(const fs::path& folder, const std::string& name)
    : descriptor_(::open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) return;
  struct flock place {};
  place.l_type = F_WRLCK;
  place.l_whence = SEEK_SET;
  place.l_start = static_cast<off_t>(std::hash<std::string>()(name) >> 2);  // positive
  place.l_len = 1;
  while (::fcntl(descriptor_, F_OFD_SETLKW, &place) != 0 && errno == EINTR) {
  }
}

SetLock::~SetLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

KeptOutcomes::KeptOutcomes(const fs::path& out, const std::string& made_by)
    : folder_(out / kSummaryFolder),
      made_by_(fmt::format("tagcal {} {}", TAGCAL_VERSION, made_by)) {
  std::error_code why;
  fs::create_directories(folder_, why);
  if (why) throw Error(fmt::format("{}: cannot be written: {}", folder_.string(), why.message()));
}

fs::path KeptOutcomes::file_of(const std::string& name) const { return folder_ / (name + ".json"); }

std::optional<ManyOutcome> KeptOutcomes::find(const std::string& name,
                                              const std::string& inputs) const {
  if (!fs::exists(file_of(name))) return std::nullopt;
  const Json kept = Json::parse(read_text(file_of(name)), nullptr, false);
  try {
    if (kept.at("code") == kBadInput) return std::nullopt;
    if (kept.at("made_by") != made_by_)
      throw Error(fmt::format(
          "{}: was made with other options or another version ({}); continue with those, "
          "remove it, or leave out --resume to replace it",
          file_of(name).string(), kept.at("made_by").get<std::string>()));
    if (kept.at("inputs") != inputs) return std::nullopt;
    return ManyOutcome{static_cast<ExitCode>(kept.at("code").get<int>()),
                       "",
                       kept.at("row").get<ManyOutcome::Row>(),
                       kept.at("advice").get<std::string>(),
                       kept.at("json").get<std::string>(),
                       {},
                       ""};
  } catch (const Json::exception&) {
    return std::nullopt;  // it is damaged
  }
}

void KeptOutcomes::keep(const std::string& name, const std::string& inputs,
                        const ManyOutcome& outcome) const {
  ManyOutcome::Row row = outcome.row;
  row.back() = "-";
  const Json kept{{"made_by", made_by_},
                  {"inputs", inputs},
                  {"code", outcome.code},
                  {"row", row},
                  {"advice", outcome.advice},
                  {"json", without_seconds(outcome.json)},
                  {"unit", fleet_row_json(outcome.unit)}};
  write_whole(file_of(name), kept.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace tagcal::tools
