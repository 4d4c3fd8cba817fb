#include "job/outputs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <system_error>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// One path for each file, whatever links lead to it.
fs::path place_of(const fs::path& file) {
  std::error_code unknown;
  fs::path place = fs::weakly_canonical(fs::absolute(file, unknown), unknown);
  return unknown ? file : place;
}

}  // namespace

void check_writable(const fs::path& file) {
  if (file.empty()) return;
  if (fs::is_directory(file)) {
    throw Error(fmt::format("{}: cannot be written: it is a folder", file.string()));
  }
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) {
    throw Error(fmt::format("{}: cannot be written: no folder {}", file.string(), folder.string()));
  }
  if (is_stream(file)) return;
  // write_whole makes a new file beside the end of the links, and renames it.
  if (::access(place_of(file).parent_path().c_str(), W_OK | X_OK) != 0)
    throw Error(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
}

void check_text_writable(const fs::path& file) {
  if (is_picture_name(file))
    throw Error(
        fmt::format("{}: has the name of a picture, but what is written is a text", file.string()));
  check_writable(file);
}

void check_yaml_writable(const fs::path& file) {
  for (const char* const other : {".html", ".csv", ".json", ".svg", ".pdf"})
    if (file.extension() == other)
      throw Error(
          fmt::format("{}: has the name of another kind of file, but YAML is written: end "
                      "it in .yaml",
                      file.string()));
  check_text_writable(file);
}

void check_drawing_writable(const fs::path& file) {
  if (!file.empty() && file.extension() != ".svg" && file.extension() != ".png")
    throw Error(fmt::format("{}: must end in .svg or .png", file.string()));
  check_writable(file);
}

void check_replaces_nothing(const std::vector<fs::path>& outputs,
                            const std::vector<fs::path>& inputs) {
  std::error_code unknown;
  std::set<fs::path> read, written;
  if (std::ranges::any_of(outputs, [&](const fs::path& file) { return fs::exists(file, unknown); }))
    for (const fs::path& file : inputs)
      if (!file.empty()) read.insert(place_of(file));
  for (const fs::path& file : outputs) {
    if (file.empty() || is_stream(file)) continue;
    const fs::path place = place_of(file);
    if (read.contains(place))
      throw Error(fmt::format("{}: is an input, which would be replaced", file.string()));
    if (!written.insert(place).second)
      throw Error(fmt::format("{}: two options would write it", file.string()));
  }
}

void check_new_files(const fs::path& folder, const std::vector<fs::path>& files,
                     const std::vector<fs::path>& inputs, bool force) {
  std::error_code none;
  for (const fs::path& name : files) {
    const fs::path file = folder / name;
    if (!fs::exists(file, none)) continue;
    for (const fs::path& input : inputs)
      if (!input.empty() && fs::equivalent(file, input, none))
        throw Error(
            fmt::format("{}: would be replaced by the result: take another --out", input.string()));
    if (!force)
      throw Error(
          fmt::format("{}: exists: take another --out, or --force to replace it", file.string()));
  }
}

}  // namespace tagcal::tools
