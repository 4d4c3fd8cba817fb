#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

enum class LensType { perspective, fisheye, parallel };

// Role of a lens parameter.
enum class ParameterKind { focal_length, principal_point, radial, tangential };
// The kind of a parameter by its name: f, fx, fy; cx, cy; k1 .. k6; p1, p2.
ParameterKind parameter_kind(std::string_view name);

// A parameter that a model leaves free, and the lens parameters (by index) that it sets: the `f` of
// the square-pixel models sets fx and fy.
struct FreeParameter {
  std::string_view name;
  std::vector<int> lens_parameters;

  ParameterKind kind() const { return parameter_kind(name); }
};

class HeldModels;

// A candidate model of a camera: a lens type and the set of its free parameters. The other
// parameters are held: the principal point at the centre of the image, the distortion at zero, or
// all at the values of HeldModels.
class Model {
 public:
  // Throws Error, with the known names, for an unknown name.
  static const Model& named(std::string_view name);
  // All models, from the smallest to the largest number of parameters:
  // weak, f, f+c, pinhole, radial1, radial2, opencv4, fisheye4, opencv5, opencv8.
  static std::span<const Model> all();

  Model(std::string_view name, LensType lens_type, std::vector<FreeParameter> free);

  // The model of another name with the same held values as this one, and all such models. Equal to
  // `named` and `all` if this model has no held values.
  const Model& sibling(std::string_view name) const;
  std::vector<const Model*> siblings() const;

  std::string_view name() const { return name_; }
  LensType lens_type() const { return lens_type_; }
  int num_free() const { return static_cast<int>(free_.size()); }
  const std::vector<FreeParameter>& free() const { return free_; }

  // The lens with these free and the held parameters. No value if the parameters define no lens (a
  // focal length that is not positive, a value that is not finite).
  std::optional<Lens> lens(std::span<const double> free_values, const ImageSize& size) const;

  // The free parameters of a lens of this type; a tied one (f) is the mean of its parameters.
  std::vector<double> free_values(const Lens& lens) const;

  // True if the model has the camera's lens among its own, to the last bit.
  bool contains(const Camera& camera) const;

  // Lens parameters (by index) that HeldModels holds, and their values.
  const std::map<int, double>& held() const { return held_; }

 private:
  friend class HeldModels;

  std::string_view name_;
  LensType lens_type_;
  std::vector<FreeParameter> free_;
  std::map<int, double> held_;
  const HeldModels* siblings_ = nullptr;
};

// All candidate models with some parameters held at given values. Each model loses the free
// parameters that set a held one. In a model with square pixels (one `f`) a held fx also holds fy,
// at the same value unless another is given.
class HeldModels {
 public:
  // `values` has the lens' names as keys (fx, fy, cx, cy, k1, ..); f stands for fx and fy.
  // Distortion is held only in models of `lens_type`, because the coefficients of other lenses mean
  // something else. Throws Error for a name that the lens type does not have, a value that is not
  // finite, and a focal length <= 0.
  HeldModels(const std::map<std::string, double>& values, LensType lens_type);
  HeldModels(const HeldModels&) = delete;
  HeldModels& operator=(const HeldModels&) = delete;

  // The model of that name. If it has no free parameter left, the next larger model with the same
  // lens that has one, if any. Throws Error as Model::named does.
  const Model& named(std::string_view name) const;
  // The models with a free parameter, and weak, without those that equal a smaller one.
  std::vector<const Model*> all() const;

 private:
  std::vector<Model> models_;
};

}  // namespace tagcal
