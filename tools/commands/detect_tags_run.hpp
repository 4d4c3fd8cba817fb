#pragma once

#include <functional>
#include <string>
#include <vector>

#include "job/input.hpp"
#include "job/output_folder.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// `detect` without a target: all tags of a family in pictures.
struct TagSearch {
  InputArguments input;
  int border_bits = 1;
  std::string out;     // a CSV file; "": stdout
  std::string camera;  // a file, or ""
  std::string draw;    // a folder, or ""
  int threads = 0;
  bool verbose = false;
  bool json = false;
};

// Fills in a view for each tag in the pictures, whose ids may repeat, and a board for each id, of
// the input's size of tags.
void find_views_of_tags(const TagSearch& search, Input& input, const Camera* camera);

// What to type if no picture shows a tag of the family, but the first one shows tags of another
// kind; else "".
std::string other_kind_text(const Input& input);

// Prints or writes the corners with the column `instance`. Returns the exit code.
int run_tag_search(const TagSearch& search);

// Draws all pictures of the input into the folder at `to`, and says so.
void draw_pictures(const Input& input, const std::string& to, OutputFolder& folder,
                   const std::function<ImageRgb(std::size_t picture)>& draw);

// Names of the drawings: each picture is drawn under its own name, whatever its folder and format.
std::vector<std::string> drawing_names(const Input& input, const std::string& folder);

// The camera of a file, for pictures of its size; none for "".
std::optional<Camera> known_camera(const std::string& file, const Input& input);

}  // namespace tagcal::tools
