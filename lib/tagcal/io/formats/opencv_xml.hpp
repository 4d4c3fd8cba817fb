#pragma once

#include <memory>
#include <string>

#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::internal {

// The tree of an XML file by cv::FileStorage. `file` is its name in messages. Throws Error.
std::shared_ptr<const YamlNode> parse_opencv_xml(const std::string& text, const std::string& file);

}  // namespace tagcal::internal
