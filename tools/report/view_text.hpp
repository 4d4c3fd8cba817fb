#pragma once

#include <string>

#include "job/view_report.hpp"
#include "job/view_values.hpp"

namespace tagcal::tools {

// The matrices and the rows of the point; with `steps` all named steps between them.
std::string view_text(const ViewReport& report, bool steps);
std::string view_json(const ViewReport& report);

// The camera as OpenGL's matrices, with a snippet to paste.
std::string view_opengl(const ViewReport& report);

// All named steps of the pipeline by name, and the same as text.
Json steps_json(const ViewReport& report);
std::string steps_text(const Json& steps);

// Parts of it: the camera's position and attitude in all parametrisations, the plane of the point's
// board, seen in the image, and the line to another point, clipped to the image and the volume.
Json camera_steps(const ViewReport& report);
Json board_plane_steps(const ViewReport& report);
Json line_steps(const ViewReport& report);

// The camera as OpenGL's matrices.
Json opengl_json(const ViewReport& report);

}  // namespace tagcal::tools
