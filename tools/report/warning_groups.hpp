#pragma once

#include <string>
#include <vector>

namespace tagcal::tools {

// One line for warnings that say the same of many pictures: "a.png: TEXT" and those that differ in
// names and numbers only become "a.png: TEXT; and 7 more pictures like it: b.png, c.png, .." in the
// place of the first. Two of a kind stay as they are.
std::vector<std::string> in_groups(const std::vector<std::string>& warnings);

}  // namespace tagcal::tools
