#pragma once

#include <string_view>

// The files of tools/page/dist, which cmake/embed_text.cmake compiles into the program.

namespace tagcal::tools {

std::string_view page_skeleton();
std::string_view page_style();
std::string_view page_script();

}  // namespace tagcal::tools
