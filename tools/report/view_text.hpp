#pragma once

#include <string>

#include "job/view_report.hpp"

namespace tagcal::tools {

// The matrices and the rows of the point; with `steps` all named steps between them.
std::string view_text(const ViewReport& report, bool steps);
std::string view_json(const ViewReport& report);

// The camera as OpenGL's matrices, with a snippet to paste.
std::string view_opengl(const ViewReport& report);

}  // namespace tagcal::tools
