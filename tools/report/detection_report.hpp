#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "job/input.hpp"

namespace tagcal::tools {

// What a search of pictures for a target came to, for a person: how many pictures show it, and the
// pictures to look at by name. `verbose`: a line for each picture. `is_explained`: --explain was
// given.
std::string detection_summary(const Input& input, bool verbose, bool is_explained);

// The same for tags of a family without a target: `num_tags` for each of the pictures.
std::string tag_summary(const std::vector<std::string>& pictures,
                        const std::vector<std::size_t>& num_tags, const std::string& family,
                        bool verbose);

// Both for a program: the pictures, what was said about them, and the corners (rows_json).
nlohmann::ordered_json detection_json(const Input& input, nlohmann::ordered_json corners);
nlohmann::ordered_json tags_json(const std::vector<std::string>& pictures,
                                 const std::vector<std::size_t>& num_tags, const Input& input,
                                 nlohmann::ordered_json corners);

}  // namespace tagcal::tools
