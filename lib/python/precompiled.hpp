#pragma once

// What every file of the module includes, of others: `#pragma once` of our own headers fails in a
// precompiled header that a compiler cache brings from another checkout.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
