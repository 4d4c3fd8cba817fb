#include "tagcal/io/formats/opencv_xml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tagcal/error.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text/number_text.hpp"

namespace tagcal::internal {
namespace {

// cv::FileStorage recurses by element, so that deeply nested ones would overflow its stack.
void check_depth(const std::string& text, const std::string& file) {
  int depth = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const char next = at + 1 < text.size() ? text[at + 1] : ' ';
    if (next == '/') --depth;
    if (next != '/' && next != '!' && next != '?') ++depth;
    if (depth > limits::kMaxYamlDepth)
      throw Error(fmt::format("{}: nested more than {} levels deep", file, limits::kMaxYamlDepth));
  }
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

}  // namespace

std::shared_ptr<const YamlNode> parse_opencv_xml(const std::string& text, const std::string& file) {
  if (text.size() > limits::kMaxYamlBytes) throw Error(file + ": larger than 16 MiB");
  if (text.find('\0') != std::string::npos) throw Error(file + ": is not XML: binary data");
  check_depth(text, file);
  try {
    const cv::FileStorage storage(
        text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    if (!storage.isOpened()) throw Error(file + ": is not OpenCV's XML");
    return converted(storage.root());
  } catch (const cv::Exception& error) {
    throw Error(fmt::format("{}: is not OpenCV's XML: {}", file, reason(error)));
  }
}

}  // namespace tagcal::internal
