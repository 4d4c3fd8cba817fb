#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

enum class LensType { perspective, fisheye, parallel };

// A parameter that a model leaves free, and the lens parameters (by index) that it sets: the `f` of
// the square-pixel models sets fx and fy.
struct FreeParameter {
  std::string_view name;
  std::vector<int> lens_parameters;
};

// A rung of the ladder of models: a lens and the set of its parameters that are free. Held are the
// others: the principal point at the centre of the image, the distortion at zero.
class Model {
 public:
  // Throws Error, with the known names, for an unknown one.
  static const Model& named(std::string_view name);
  // Every model, by growing number of parameters:
  // weak, f, f+c, pinhole, radial1, radial2, opencv5, fisheye4, opencv8.
  static std::span<const Model> all();

  Model(std::string_view name, LensType lens_type, std::vector<FreeParameter> free);

  std::string_view name() const { return name_; }
  LensType lens_type() const { return lens_type_; }
  int num_free() const { return static_cast<int>(free_.size()); }
  const std::vector<FreeParameter>& free() const { return free_; }

  // The lens with these free parameters and the held ones at their places. No value where the
  // parameters are no lens (a focal length that is not positive, a value that is not finite).
  std::optional<Lens> lens(std::span<const double> free_values, const ImageSize& size) const;

  // The free parameters of a lens of this type; tied ones (fx, fy) by their mean.
  std::vector<double> free_values(const Lens& lens) const;

 private:
  std::string_view name_;
  LensType lens_type_;
  std::vector<FreeParameter> free_;
};

}  // namespace tagcal
