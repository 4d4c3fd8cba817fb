#include "python/arrays.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::python {
namespace {

std::string text(const py::handle& value) { return py::cast<std::string>(py::str(value)); }

[[noreturn]] void throw_shape(const char* name, const std::string& expected,
                              const py::array& array) {
  throw Error(std::string(name) + ": must have the shape " + expected + ", got " +
              shape_text(array));
}

py::array any_array(py::handle argument, const char* name) {
  if (argument.is_none()) throw Error(std::string(name) + ": must be an array, got None");
  py::array array = py::array::ensure(argument);  // clears numpy's error
  if (!array)
    throw Error(std::string(name) + ": must be an array of numbers, got " + type_name(argument));
  return array;
}

bool is_aligned(const void* data, std::size_t bytes) {
  return reinterpret_cast<std::uintptr_t>(data) % bytes == 0;
}

void check_finite(const char* name, std::span<const double> values, std::size_t row_length) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(std::string(name) + ": must be finite, got " + text(py::float_(values[i])) +
                  " in row " + std::to_string(i / row_length));
}

// As py::isinstance<py::array_t<double>>, without making a dtype to compare with.
bool is_double_array(py::handle object) {
  namespace detail = py::detail;
  if (!detail::npy_api::get().PyArray_Check_(object.ptr())) return false;
  const auto* const dtype =
      detail::array_descriptor_proxy(detail::array_proxy(object.ptr())->descr);
  return dtype->type_num == detail::npy_api::NPY_DOUBLE_ && dtype->byteorder == '=';
}

}  // namespace

std::string shape_text(const py::array& array) { return text(array.attr("shape")); }

py::array_t<double> real_array(py::handle argument, const char* name) {
  using Contiguous = py::array_t<double, py::array::c_style | py::array::forcecast>;
  constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  if (is_double_array(argument)) {
    auto array = py::reinterpret_borrow<py::array_t<double>>(argument);
    if ((array.flags() & py::array::c_style) != 0 && (array.flags() & kAligned) != 0) return array;
  }
  const py::array array = any_array(argument, name);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw Error(std::string(name) + ": must be an array of real numbers, got dtype " +
                text(array.dtype()));
  auto doubles = Contiguous::ensure(array);
  if (!doubles) throw Error(std::string(name) + ": cannot be read as float64");
  if ((doubles.flags() & kAligned) == 0) doubles = Contiguous(array.attr("copy")());
  return doubles;
}

void read_matrix(py::handle argument, const char* name, std::span<double> row_major, int rows,
                 int columns) {
  const py::array_t<double> array = real_array(argument, name);
  const bool is_vector =  // OpenCV returns columns and rows
      array.ndim() == 1 || (array.ndim() == 2 && (array.shape(0) == 1 || array.shape(1) == 1));
  const bool fits = columns == 0
                        ? is_vector && array.size() == rows
                        : array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns;
  if (!fits)
    throw_shape(name,
                columns == 0 ? "(" + std::to_string(rows) + ",)"
                             : "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")",
                array);
  std::memcpy(row_major.data(), array.data(), row_major.size_bytes());
  check_finite(name, row_major, columns == 0 ? 1 : static_cast<std::size_t>(columns));
}

Eigen::Vector2d vector2(py::handle argument, const char* name) {
  Eigen::Vector2d v;
  read_matrix(argument, name, {v.data(), 2}, 2, 0);
  return v;
}

Eigen::Vector3d vector3(py::handle argument, const char* name) {
  Eigen::Vector3d v;
  read_matrix(argument, name, {v.data(), 3}, 3, 0);
  return v;
}

Eigen::Matrix3d matrix3(py::handle argument, const char* name) {
  Eigen::Matrix3d m;
  read_matrix(argument, name, {m.data(), 9}, 3, 3);
  return m.transpose();
}

Eigen::Matrix4d matrix4(py::handle argument, const char* name) {
  Eigen::Matrix4d m;
  read_matrix(argument, name, {m.data(), 16}, 4, 4);
  return m.transpose();
}

template <typename Vector>
Rows<Vector>::Rows(py::handle argument, const char* name, Check check)
    : array_(real_array(argument, name)) {
  constexpr py::ssize_t kColumns = Vector::RowsAtCompileTime;
  static_assert(sizeof(Vector) == kColumns * sizeof(double));
  is_single_ = array_.ndim() == 1 && array_.shape(0) == kColumns;
  if (!is_single_ && !(array_.ndim() == 2 && array_.shape(1) == kColumns))
    throw_shape(name, "(N, " + std::to_string(kColumns) + ")", array_);
  const std::size_t n = is_single_ ? 1 : static_cast<std::size_t>(array_.shape(0));
  if (is_aligned(array_.data(), alignof(Vector))) {
    rows_ = {reinterpret_cast<const Vector*>(array_.data()), n};
  } else {
    copy_.resize(n);
    if (n > 0) std::memcpy(static_cast<void*>(copy_.data()), array_.data(), n * sizeof(Vector));
    rows_ = copy_;
  }
  if (check == Check::finite)
    check_finite(name, {array_.data(), n * kColumns}, static_cast<std::size_t>(kColumns));
}
template class Rows<Eigen::Vector2d>;
template class Rows<Eigen::Vector3d>;

void check_same_length(std::size_t a, const char* name_a, std::size_t b, const char* name_b) {
  if (a != b)
    throw Error(std::string(name_b) + ": must have as many rows as " + name_a + " (" +
                std::to_string(a) + "), got " + std::to_string(b));
}

std::vector<Matrix2> covariances2(py::handle argument, const char* name, std::size_t n) {
  if (argument.is_none()) return {};
  const py::array_t<double> array = real_array(argument, name);
  const bool is_one = array.ndim() == 2 && array.shape(0) == 2 && array.shape(1) == 2;
  if (!is_one && !(array.ndim() == 3 && array.shape(0) == static_cast<py::ssize_t>(n) &&
                   array.shape(1) == 2 && array.shape(2) == 2))
    throw_shape(name, "(" + std::to_string(n) + ", 2, 2) or (2, 2)", array);
  std::vector<Matrix2> matrices(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* m = array.data() + (is_one ? 0 : 4 * i);
    matrices[i] << m[0], m[1], m[2], m[3];
    const double asymmetry = std::abs(m[1] - m[2]);
    const bool positive = m[0] > 0 && m[0] * m[3] - m[1] * m[2] > 0;
    if (!matrices[i].allFinite() || !positive || asymmetry > 1e-9 * std::sqrt(m[0] * m[3]))
      throw Error(std::string(name) + ": must be symmetric and positive definite, got " +
                  text(py::float_(m[0])) + ", " + text(py::float_(m[1])) + ", " +
                  text(py::float_(m[2])) + ", " + text(py::float_(m[3])) + " in matrix " +
                  std::to_string(i));
  }
  return matrices;
}

double* output_array(py::handle argument, const char* name, std::span<const py::ssize_t> shape) {
  std::string expected = "(";
  for (const py::ssize_t extent : shape) expected += std::to_string(extent) + ", ";
  expected.erase(expected.size() - (shape.size() > 1 ? 2 : 1));
  expected += ")";
  const std::string must = std::string(name) +
                           ": must be a writable, C-contiguous float64 array of the shape " +
                           expected + ", got ";
  if (!is_double_array(argument))
    throw Error(must + (py::isinstance<py::array>(argument)
                            ? "dtype " + text(argument.attr("dtype"))
                            : type_name(argument)));
  auto array = py::reinterpret_borrow<py::array_t<double>>(argument);
  if (!std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim()))
    throw Error(must + shape_text(array));
  if ((array.flags() & py::array::c_style) == 0 || !is_aligned(array.data(), sizeof(double)))
    throw Error(must + "strides " + text(array.attr("strides")));
  if (!array.writeable()) throw Error(must + "a read-only one");
  return array.mutable_data();
}

namespace {

template <typename Vector>
py::array_t<double> rows_array(std::span<const Vector> rows) {
  constexpr py::ssize_t kColumns = Vector::RowsAtCompileTime;
  py::array_t<double> array({static_cast<py::ssize_t>(rows.size()), kColumns});
  if (!rows.empty()) std::memcpy(array.mutable_data(), rows.data(), rows.size_bytes());
  return array;
}

template <typename T>
struct Values {  // of one pixel
  using Type = T;
  static constexpr py::ssize_t kCount = 1;
};
template <typename T>
struct Values<std::array<T, 3>> {
  using Type = T;
  static constexpr py::ssize_t kCount = 3;
};

template <typename T>
Image<T> image_of(const py::array& array) {
  const py::array_t<typename Values<T>::Type, py::array::c_style> values(array);
  Image<T> image({static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))});
  std::memcpy(image.row(0), values.data(), static_cast<std::size_t>(values.nbytes()));
  return image;
}

// Throws Error unless the array is a picture of uint8 or uint16.
void check_picture(const py::array& array, const char* name, bool colour_too) {
  const bool is_colour = array.ndim() == 3;
  if (is_colour && !colour_too)
    throw Error(std::string(name) + ": must be grey, of the shape (height, width), got " +
                shape_text(array) + "; convert it, for example with cv2.cvtColor");
  if (array.ndim() != 2 && !(is_colour && array.shape(2) == 3))
    throw_shape(name, colour_too ? "(height, width) or (height, width, 3)" : "(height, width)",
                array);
  try {
    check_pixel_count(array.shape(1), array.shape(0));
  } catch (const Error& error) {
    throw Error(std::string(name) + ": " + error.what());
  }
}

}  // namespace

py::array_t<double> matrix_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  py::array_t<double> array({matrix.rows(), matrix.cols()});
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajor>(array.mutable_data(), matrix.rows(), matrix.cols()) = matrix;
  return array;
}

py::array_t<double> array_of(std::span<const Eigen::Vector2d> rows) { return rows_array(rows); }
py::array_t<double> array_of(std::span<const Eigen::Vector3d> rows) { return rows_array(rows); }

template <typename T>
PictureArray<T>::PictureArray(py::handle argument, const char* name)
    : array_(any_array(argument, name)) {
  check_picture(array_, name, false);
  if (!has_type<T>(array_))
    throw Error(std::string(name) + ": must be uint" + std::to_string(8 * sizeof(T)) + ", got " +
                text(array_.dtype()));
  const py::ssize_t row_bytes = array_.shape(1) * static_cast<py::ssize_t>(sizeof(T));
  const bool in_place = array_.strides(1) == sizeof(T) && array_.strides(0) >= row_bytes &&
                        array_.strides(0) % sizeof(T) == 0 && is_aligned(array_.data(), sizeof(T));
  if (!in_place) array_ = py::array_t<T, py::array::c_style>(array_.attr("copy")("C"));
  view_ = ImageView<T>(static_cast<const T*>(array_.data()),
                       {static_cast<int>(array_.shape(1)), static_cast<int>(array_.shape(0))},
                       array_.strides(0) / static_cast<py::ssize_t>(sizeof(T)));
}
template class PictureArray<std::uint8_t>;
template class PictureArray<std::uint16_t>;

template <typename T>
py::array array_of(const Image<T>& image) {
  using Value = typename Values<T>::Type;
  constexpr py::ssize_t kCount = Values<T>::kCount;
  std::vector<py::ssize_t> shape = {image.height(), image.width()};
  if (kCount > 1) shape.push_back(kCount);
  py::array_t<Value> array(shape);
  if (!image.empty())
    std::memcpy(array.mutable_data(), image.row(0), static_cast<std::size_t>(array.nbytes()));
  return array;
}
template py::array array_of(const Image8&);
template py::array array_of(const Image16&);
template py::array array_of(const ImageF&);
template py::array array_of(const ImageRgb&);
template py::array array_of(const ImageRgb16&);

py::array array_of(const Picture& picture) {
  return std::visit([](const auto& image) { return array_of(image); }, picture);
}

Picture picture_of(py::handle argument, const char* name) {
  const py::array array = any_array(argument, name);
  check_picture(array, name, true);
  const bool is_grey = array.ndim() == 2;
  if (has_type<std::uint8_t>(array)) {
    if (is_grey) return image_of<std::uint8_t>(array);
    return image_of<Rgb>(array);
  }
  if (has_type<std::uint16_t>(array)) {
    if (is_grey) return image_of<std::uint16_t>(array);
    return image_of<Rgb16>(array);
  }
  throw Error(std::string(name) + ": must be uint8 or uint16, got " + text(array.dtype()));
}

}  // namespace tagcal::python
