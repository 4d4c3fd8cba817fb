#include "tagcal/io/formats/opencv_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

// The end of the markup that begins at `at`, or npos: of a comment, an instruction or a tag, whose
// values may have any character between quotes.
std::size_t end_of_markup(const std::string& text, std::size_t at) {
  if (text.compare(at, 4, "<!--") == 0) return text.find("-->", at + 4);
  if (text.compare(at, 2, "<?") == 0) return text.find("?>", at + 2);
  do {
    at = text.find_first_of("<>\"'", at + 1);
    if (at == std::string::npos || text[at] == '<') return std::string::npos;
    if (text[at] == '>') return at;
    at = text.find(text[at], at + 1);  // the other quote
  } while (at != std::string::npos);
  return std::string::npos;
}

// cv::FileStorage recurses by element, so that deeply nested ones would overflow its stack; and it
// reads beyond the text where this ends within an element (OpenCV 4.6).
void check_elements(const std::string& text, const std::string& file) {
  int depth = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    const std::size_t end = end_of_markup(text, at);
    if (end == std::string::npos)
      throw Error(file + ": is not OpenCV's XML: an element, comment or value has no end");
    const char first = text[at + 1];
    const bool is_element = first != '!' && first != '?';
    if (is_element && text[end - 1] != '/') depth += first == '/' ? -1 : 1;
    if (depth > limits::kMaxYamlDepth)
      throw Error(fmt::format("{}: nested more than {} levels deep", file, limits::kMaxYamlDepth));
    at = end;
  }
  if (depth != 0) throw Error(file + ": is not OpenCV's XML: an element has no end");
}

std::shared_ptr<const YamlNode> converted(const cv::FileNode& node) {
  auto result = std::make_shared<YamlNode>();
  if (node.isMap() || node.isSeq()) {
    result->kind = node.isMap() ? YamlNode::Kind::map : YamlNode::Kind::list;
    for (const cv::FileNode child : node)
      result->children.emplace_back(node.isMap() ? child.name() : "", converted(child));
  } else if (node.isInt()) {
    result->kind = YamlNode::Kind::scalar;
    result->scalar = fmt::to_string(static_cast<int>(node));
  } else if (node.isReal()) {
    result->kind = YamlNode::Kind::scalar;
    result->scalar = number_text(static_cast<double>(node));
  } else if (node.isString()) {
    result->kind = YamlNode::Kind::scalar;
    result->scalar = static_cast<std::string>(node);
    result->quoted = true;
  }
  return result;
}

// The first line of OpenCV's message, without its place in OpenCV's source.
std::string reason(const cv::Exception& error) {
  const std::string text = error.err.empty() ? std::string(error.what()) : error.err;
  return shown(text.substr(0, text.find('\n')));
}

// The tree of an XML file. Throws Error.
std::shared_ptr<const YamlNode> parse_xml(const std::string& text, const std::string& file) {
  if (text.size() > limits::kMaxYamlBytes) throw Error(file + ": larger than 16 MiB");
  if (text.find('\0') != std::string::npos) throw Error(file + ": is not XML: binary data");
  check_elements(text, file);
  try {
    const cv::FileStorage storage(
        text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    if (!storage.isOpened()) throw Error(file + ": is not OpenCV's XML");
    return converted(storage.root());
  } catch (const cv::Exception& error) {
    throw Error(fmt::format("{}: is not OpenCV's XML: {}", file, reason(error)));
  }
}

}  // namespace

YamlValue parse_storage(const std::string& text, const std::string& file) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool is_xml = first != std::string::npos && text[first] == '<';
  return is_xml ? YamlValue::of(parse_xml(text, file), file) : YamlValue::parse(text, file);
}

}  // namespace tagcal::internal
