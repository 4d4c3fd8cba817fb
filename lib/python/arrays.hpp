#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "python/arguments.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/scene/image.hpp"

// Arguments from numpy. Every function throws Error with the argument's name, what it must be and
// what it is: "points: must have the shape (N, 3), got (4, 2)". Lists, tuples and arrays of other
// real types are converted; arrays of float64 are read in place if their rows are contiguous.

namespace tagcal::python {

namespace py = pybind11;

// An argument that may be anything that numpy makes an array of; the functions below check it.
using ArrayLike = Argument<"ArrayLike">;

// An array that a result is written into; output_array() checks it.
using OutputArray = Argument<"OutputArray">;

// "(4, 2)", for messages.
std::string shape_text(const py::array& array);

// An array of float64, contiguous and aligned, of a real dtype before. `name`: of the argument.
py::array_t<double> real_array(py::handle argument, const char* name);

// A fixed matrix or vector of finite numbers, such as a pose or a point. A vector may be a row or a
// column.
void read_matrix(py::handle argument, const char* name, std::span<double> row_major, int rows,
                 int columns);  // columns 0: a vector
Eigen::Vector2d vector2(py::handle argument, const char* name);
Eigen::Vector3d vector3(py::handle argument, const char* name);
Eigen::Matrix3d matrix3(py::handle argument, const char* name);
Eigen::Matrix4d matrix4(py::handle argument, const char* name);

// (N, K) numbers as N vectors, in the memory of the array where its layout allows. One vector of
// the shape (K,) counts as one row.
template <typename Vector>
class Rows {
 public:
  enum class Check { finite, none };
  Rows(py::handle argument, const char* name, Check check = Check::finite);

  std::span<const Vector> span() const { return rows_; }
  std::size_t size() const { return rows_.size(); }
  const Vector& operator[](std::size_t i) const { return rows_[i]; }
  bool is_single() const { return is_single_; }

 private:
  py::array_t<double> array_;  // keeps the memory
  std::vector<Vector> copy_;   // if it is not aligned
  std::span<const Vector> rows_;
  bool is_single_ = false;
};
using Rows2 = Rows<Eigen::Vector2d>;
using Rows3 = Rows<Eigen::Vector3d>;

// Throws Error unless both have the same number of rows.
void check_same_length(std::size_t a, const char* name_a, std::size_t b, const char* name_b);

// (N, 2, 2) symmetric positive definite matrices, or (2, 2) for all N; None: empty.
std::vector<Matrix2> covariances2(py::handle argument, const char* name, std::size_t n);

// An array that a result is written into: C-contiguous, writable float64 of this shape.
double* output_array(py::handle argument, const char* name, std::span<const py::ssize_t> shape);

// A copy of a matrix as an array (rows, columns).
py::array_t<double> matrix_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

// A copy of vectors as an (N, K) array.
py::array_t<double> array_of(std::span<const Eigen::Vector2d> rows);
py::array_t<double> array_of(std::span<const Eigen::Vector3d> rows);

// True for an array of this type of whole numbers.
template <typename T>
bool has_type(const py::array& array) {
  return array.dtype().kind() == 'u' && array.itemsize() == sizeof(T) &&
         py::isinstance<py::array_t<T>>(array);
}

// A picture (height, width) of uint8 (or uint16) in the memory of numpy, whose pixels of a row must
// be contiguous; a copy otherwise. Throws Error for other types, colour (the message says how to
// convert it) and pictures without pixels.
template <typename T>
class PictureArray {
 public:
  PictureArray(py::handle argument, const char* name);
  const ImageView<T>& view() const { return view_; }

 private:
  py::array array_;
  ImageView<T> view_;
};

// Pictures as arrays: (height, width) or (height, width, 3), uint8, uint16 or float32.
template <typename T>
py::array array_of(const Image<T>& image);
py::array array_of(const Picture& picture);
// The way back, a copy. Throws Error as PictureArray does, but takes (height, width, 3), red first.
Picture picture_of(py::handle argument, const char* name);

}  // namespace tagcal::python
