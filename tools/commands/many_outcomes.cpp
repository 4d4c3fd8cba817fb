#include "commands/many_outcomes.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "job/command_line.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

fs::path made_folder(fs::path folder) {
  fs::create_directories(folder);
  return folder;
}

}  // namespace

KeptOutcomes::KeptOutcomes(const fs::path& out)
    : folder_(made_folder(out / WorkFile::kName)),
      work_(folder_, fmt::format("tagcal {}\n{}\n", TAGCAL_VERSION, command_as_typed())) {}

fs::path KeptOutcomes::file_of(const std::string& name) const { return folder_ / (name + ".json"); }

std::optional<ManyOutcome> KeptOutcomes::find(const std::string& name,
                                              const std::string& inputs) const {
  if (!fs::exists(file_of(name))) return std::nullopt;
  const Json kept = Json::parse(read_text(file_of(name)), nullptr, false);
  if (!kept.is_object() || kept.value("inputs", "") != inputs) return std::nullopt;
  return ManyOutcome{static_cast<ExitCode>(kept.value("code", 2)), "",
                     kept.at("row").get<ManyOutcome::Row>(), kept.value("advice", ""),
                     kept.value("json", "")};
}

void KeptOutcomes::keep(const std::string& name, const std::string& inputs,
                        const ManyOutcome& outcome) const {
  const Json kept{{"inputs", inputs},
                  {"code", outcome.code},
                  {"row", outcome.row},
                  {"advice", outcome.advice},
                  {"json", outcome.json}};
  write_whole(file_of(name), kept.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void KeptOutcomes::finish() const {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

}  // namespace tagcal::tools
