#include "page_data/pages.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string_view>
#include <system_error>

#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "page_data/page_assets.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

std::string escaped(const std::string& json) {
  std::string text;
  text.reserve(json.size() + json.size() / 64);
  for (const char c : json) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

// Returns false for a file that is neither empty nor HTML: a picture, or a calibration.
bool may_be_replaced(const fs::path& file) {
  constexpr std::string_view kStart = "<!DOCTYPE html";
  std::string start(kStart.size(), '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  return stream.gcount() == 0 || start == kStart;
}

// The page as one HTML file. Bytes that are not UTF-8 are replaced, and "<" is escaped, so that no
// text of the data can end the script that holds them.
std::string html_page(const PageJson& data) {
  const std::string json = escaped(json_text(data, -1));
  const std::pair<std::string_view, std::string_view> marks[] = {
      {"@CSS@", page_style()}, {"@DATA@", json}, {"@JS@", page_script()}};
  std::string_view rest = page_skeleton();
  std::string page;
  page.reserve(json.size() + 2 * page_script().size());
  for (const auto& [mark, content] : marks) {  // in this order; no mark is looked for in a content
    const std::size_t at = rest.find(mark);
    page.append(rest.substr(0, at)).append(content);
    rest.remove_prefix(at + mark.size());
  }
  return page.append(rest);
}

}  // namespace

void check_page(const fs::path& out, const std::vector<std::string>& inputs) {
  check_text_writable(out);
  check_replaces_nothing({out}, {inputs.begin(), inputs.end()});
  std::error_code unknown;
  if (is_stream(out)) return;
  if (fs::exists(out, unknown) && !may_be_replaced(out))
    throw Error(fmt::format("{}: exists and is no HTML page, which the report would replace",
                            out.string()));
  const std::string ending = out.extension().string();
  if (ending == ".pdf")
    throw Error(
        fmt::format("{0}: the report is an HTML page: --out {1}, which a browser prints "
                    "as PDF (chromium --headless --print-to-pdf={0} {1})",
                    out.string(), fs::path(out).replace_extension(".html").string()));
  if (ending != ".html" && ending != ".htm")
    throw Error(fmt::format("{}: the report is an HTML page: must end in .html", out.string()));
}

void write_page(const fs::path& out, const PageJson& data) {
  write_whole(out, html_page(data));
  say_wrote(out);
}

}  // namespace tagcal::tools
