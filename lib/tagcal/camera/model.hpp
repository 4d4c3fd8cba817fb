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

// A parameter that a model leaves free, and the lens parameters (by index) that it sets: the `f` of
// the square-pixel models sets fx and fy.
struct FreeParameter {
  std::string_view name;
  std::vector<int> lens_parameters;
};

class HeldModels;

// A rung of the ladder of models: a lens and the set of its parameters that are free. Held are the
// others: the principal point at the centre of the image, the distortion at zero, or where
// HeldModels says.
class Model {
 public:
  // Throws Error, with the known names, for an unknown one.
  static const Model& named(std::string_view name);
  // Every model, by growing number of parameters:
  // weak, f, f+c, pinhole, radial1, radial2, opencv5, fisheye4, opencv8.
  static std::span<const Model> all();

  Model(std::string_view name, LensType lens_type, std::vector<FreeParameter> free);

  // The model of another name that holds the same values as this one (`named`, where it holds
  // none), and all of them (`all`).
  const Model& sibling(std::string_view name) const;
  std::vector<const Model*> siblings() const;

  std::string_view name() const { return name_; }
  LensType lens_type() const { return lens_type_; }
  int num_free() const { return static_cast<int>(free_.size()); }
  const std::vector<FreeParameter>& free() const { return free_; }

  // The lens with these free parameters and the held ones at their places. No value where the
  // parameters are no lens (a focal length that is not positive, a value that is not finite).
  std::optional<Lens> lens(std::span<const double> free_values, const ImageSize& size) const;

  // The free parameters of a lens of this type; tied ones (fx, fy) by their mean.
  std::vector<double> free_values(const Lens& lens) const;

  // Lens parameters (by index) that are held at values of their own.
  const std::map<int, double>& held() const { return held_; }

 private:
  friend class HeldModels;

  std::string_view name_;
  LensType lens_type_;
  std::vector<FreeParameter> free_;
  std::map<int, double> held_;
  const HeldModels* siblings_ = nullptr;
};

// The ladder of models with some parameters held at given values. Each model loses the free
// parameters that set one of them: of models with square pixels (one `f`), holding fx holds fy,
// too, and at the same value unless that is given.
class HeldModels {
 public:
  // `values` by the lens' names (fx, fy, cx, cy, k1, ..), f for fx and fy. Distortion is held in
  // the models of `lens_type` only: the coefficients of others are others. Throws Error for a name
  // that no lens of the type has, or a value that is none (not finite; a focal length <= 0).
  HeldModels(const std::map<std::string, double>& values, LensType lens_type);
  HeldModels(const HeldModels&) = delete;
  HeldModels& operator=(const HeldModels&) = delete;

  // The model of that name, or the next larger one with its lens that has something free, if there
  // is one. Throws Error as Model::named does.
  const Model& named(std::string_view name) const;
  // Those that have something free (and weak), without those that are alike a smaller one.
  std::vector<const Model*> all() const;

 private:
  std::vector<Model> models_;
};

}  // namespace tagcal
