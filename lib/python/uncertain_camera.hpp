#pragma once

#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "python/arguments.hpp"
#include "python/arrays.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::python {

// A camera and what is known of it: a Camera (taken as exact), an UncertainCamera (which is
// CalibrationFile in C++, and its `claim` is UncertainCamera) or a Calibration.
using CameraLike = Argument<"CameraLike">;

// Throws Error with the argument's name for other objects, and for a calibration without a camera.
CalibrationFile known_camera(const CameraLike& argument, const char* name);

// What is known of the camera of a calibration. Throws Error if it has no answer.
CalibrationFile known_camera(const Calibration& calibration);

// Returns the camera of an answer, no value for others: the lens is then the last state of the
// solver, or (model weak) one without the scale of each view.
std::optional<Camera> camera_of_answer(const Calibration& calibration);

// N covariances (K, K), or one for all. None: zeros. Throws Error with the argument's name.
std::vector<Eigen::MatrixXd> covariance_matrices(const std::optional<ArrayLike>& argument,
                                                 const char* name, std::size_t n,
                                                 pybind11::ssize_t k);

}  // namespace tagcal::python
