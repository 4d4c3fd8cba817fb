#pragma once

#include <string>

#include "tagcal/io/types.hpp"

namespace CLI {
class App;
}  // namespace CLI

// `tagcal convert --model`: another lens model for the cameras of a file
// (docs/reference/models.md).

namespace tagcal::tools {

struct ModelArguments {
  std::string model;             // "": the lenses stay as they are
  double max_difference_px = 0;  // 0: the default of fit_lens
  std::string picture;           // of the difference; "": none
};

void add_model_options(CLI::App& command, ModelArguments& arguments);

// Throws Error for options that need another one, a model that cannot be fitted, and a picture of
// an unknown kind.
void check_usage(const ModelArguments& arguments);

// Fits a lens of the model to each camera of the file, which was read from `name`, and replaces it;
// says what remains (print_summary with `out`). Returns false, with the reasons on stderr, if one
// differs by too much. Throws Error for a camera without an image size, and a picture of several
// cameras.
bool fit_models(CameraFile& file, const std::string& name, const ModelArguments& arguments,
                const std::string& out);

}  // namespace tagcal::tools
