#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

// A parameter that a model leaves free, and the lens parameters (by index) that it sets: the `f` of
// the square-pixel models sets fx and fy.
struct FreeParameter {
  std::string_view name;
  std::vector<int> lens_parameters;
};

// Place of a model among those of its kind of lens: `usual` has all parameters but a denominator,
// `largest` has all.
enum class ModelRole { nested, usual, largest };

class HeldModels;

// A candidate model of a camera: a kind of lens and the set of its free parameters. The other
// parameters are held: the principal point at the centre of the image, the distortion at zero, or
// all at the values of HeldModels.
class Model {
 public:
  // Throws Error, with the known names, for an unknown name.
  static const Model& named(std::string_view name);
  // All models, from the smallest to the largest number of parameters:
  // weak, f, f+c, pinhole, radial1, radial2, ds, eucm, opencv4, fisheye4, opencv5, opencv8.
  static std::span<const Model> all();

  // `free`: names of the kind's parameters, or f.
  Model(std::string_view name, const LensKind& kind, std::initializer_list<std::string_view> free,
        ModelRole role = ModelRole::nested);

  // The model of another name with the same held values as this one, and all such models. Equal to
  // `named` and `all` if this model has no held values.
  const Model& sibling(std::string_view name) const;
  // The smallest sibling of a kind that has this role, or a larger one.
  const Model& sibling(const LensKind& kind, ModelRole role) const;
  std::vector<const Model*> siblings() const;

  std::string_view name() const { return name_; }
  const LensKind& kind() const { return *kind_; }
  ModelRole role() const { return role_; }
  int num_free() const { return static_cast<int>(free_.size()); }
  const std::vector<FreeParameter>& free() const { return free_; }
  // The lens parameter that the i-th free one sets, or the first of them.
  const LensParameter& parameter(std::size_t i) const {
    return kind_->parameters[static_cast<std::size_t>(free_[i].lens_parameters.front())];
  }

  // The lens with these free and the held parameters. No value if the parameters define no lens (a
  // focal length that is not positive, a value that is not finite).
  std::optional<Lens> lens(std::span<const double> free_values, const ImageSize& size) const;

  // The free parameters of a lens of this kind; a tied one (f) is the mean of its parameters.
  std::vector<double> free_values(const Lens& lens) const;

  // True if the model has the camera's lens among its own, to the last bit.
  bool contains(const Camera& camera) const;

  // Lens parameters (by index) that HeldModels holds, and their values.
  const std::map<int, double>& held() const { return held_; }

 private:
  friend class HeldModels;

  std::string_view name_;
  const LensKind* kind_;
  ModelRole role_;
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
  // Distortion is held only in models of this kind, because the coefficients of other lenses mean
  // something else. Throws Error for a name that the kind does not have, and a value that is not in
  // the parameter's range.
  HeldModels(const std::map<std::string, double>& values, const LensKind& kind);
  HeldModels(const HeldModels&) = delete;
  HeldModels& operator=(const HeldModels&) = delete;

  // The model of that name. If it has no free parameter left, the next larger model with the same
  // lens that has one, if any. Throws Error as Model::named does.
  const Model& named(std::string_view name) const;
  const Model& of(const LensKind& kind, ModelRole role) const;
  // The models with a free parameter, and weak, without those that equal a smaller one.
  std::vector<const Model*> all() const;

 private:
  std::vector<Model> models_;
};

// The usual model of a lens' kind, or the largest if the lens has coefficients that it lacks.
const Model& full_model(const Lens& lens);

}  // namespace tagcal
