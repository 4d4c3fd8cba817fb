#pragma once

#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal::tools {

// One line for warnings that say the same of many pictures: "a.png: TEXT" and those that differ in
// names and numbers only become "a.png: TEXT; and 7 more pictures like it: b.png, c.png, .." in the
// place of the first. Two of a kind stay as they are.
std::vector<std::string> in_groups(const std::vector<std::string>& warnings);
// The same for the sentences of findings, for people to read; programs get all of them.
std::vector<Finding> in_groups(std::span<const Finding> findings);

}  // namespace tagcal::tools
