#include "tagcal/camera/model.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
namespace {

const std::array<Model, 10>& candidates() {
  static const std::vector<FreeParameter> fxfycxcy = {
      {"fx", {0}}, {"fy", {1}}, {"cx", {2}}, {"cy", {3}}};
  static const auto with = [](std::vector<FreeParameter> base, std::vector<FreeParameter> more) {
    base.insert(base.end(), more.begin(), more.end());
    return base;
  };
  static const FreeParameter f = {"f", {0, 1}}, cx = {"cx", {2}}, cy = {"cy", {3}};
  static const FreeParameter k1 = {"k1", {4}}, k2 = {"k2", {5}}, p1 = {"p1", {6}}, p2 = {"p2", {7}};
  static const FreeParameter k3 = {"k3", {8}}, k4 = {"k4", {9}}, k5 = {"k5", {10}},
                             k6 = {"k6", {11}};
  static const std::array<Model, 10> models = {
      Model("weak", LensType::parallel, {}),
      Model("f", LensType::perspective, {f}),
      Model("f+c", LensType::perspective, {f, cx, cy}),
      Model("pinhole", LensType::perspective, fxfycxcy),
      Model("radial1", LensType::perspective, {f, cx, cy, k1}),
      Model("radial2", LensType::perspective, {f, cx, cy, k1, k2}),
      Model("opencv4", LensType::perspective, with(fxfycxcy, {k1, k2, p1, p2})),
      Model("fisheye4", LensType::fisheye,
            with(fxfycxcy, {{"k1", {4}}, {"k2", {5}}, {"k3", {6}}, {"k4", {7}}})),
      Model("opencv5", LensType::perspective, with(fxfycxcy, {k1, k2, p1, p2, k3})),
      Model("opencv8", LensType::perspective, with(fxfycxcy, {k1, k2, p1, p2, k3, k4, k5, k6}))};
  return models;
}

template <typename L>
std::optional<Lens> make_lens(const std::vector<FreeParameter>& free,
                              std::span<const double> values, const std::map<int, double>& held,
                              typename L::Parameters parameters) {
  for (const auto& [k, value] : held) parameters[static_cast<std::size_t>(k)] = value;
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (!std::isfinite(values[i])) return std::nullopt;
    for (const int k : free[i].lens_parameters) parameters[static_cast<std::size_t>(k)] = values[i];
  }
  if (!(parameters[0] > 0 && parameters[1] > 0)) return std::nullopt;
  return Lens(L(parameters));
}

std::span<const std::string_view> names_of(LensType type) {
  switch (type) {
    case LensType::perspective:
      return Perspective::kParameterNames;
    case LensType::fisheye:
      return Fisheye::kParameterNames;
    case LensType::parallel:
      return Parallel::kParameterNames;
  }
  return {};
}

std::string known_names(LensType type) {
  std::string known = "f";
  for (const std::string_view name : names_of(type)) known += ", " + std::string(name);
  return known;
}

// The held values by parameter index of the lens.
std::map<int, double> by_index(const std::map<std::string, double>& values, LensType type) {
  const auto names = names_of(type);
  std::map<int, double> held;
  for (const auto& [name, value] : values) {
    const auto at = std::ranges::find(names, name);
    if (name != "f" && at == names.end())
      throw Error("fixed: must be one of " + known_names(type) + "; got " + name);
    const int index = name == "f" ? 0 : static_cast<int>(at - names.begin());
    if (!std::isfinite(value) || (index < 2 && !(value > 0)))
      throw Error("fixed: " + name + " must be " + (index < 2 ? "> 0" : "a number") + ", got " +
                  internal::short_number(value));
    bool is_new = held.emplace(index, value).second;
    if (name == "f") is_new &= held.emplace(1, value).second;
    if (!is_new) throw Error("fixed: " + name + " is held twice");
  }
  return held;
}

bool alike(const Model& a, const Model& b) {
  return a.lens_type() == b.lens_type() && a.held() == b.held() &&
         std::ranges::equal(a.free(), b.free(), {}, &FreeParameter::lens_parameters,
                            &FreeParameter::lens_parameters);
}

}  // namespace

ParameterKind parameter_kind(std::string_view name) {
  switch (name.front()) {
    case 'f':
      return ParameterKind::focal_length;
    case 'c':
      return ParameterKind::principal_point;
    case 'p':
      return ParameterKind::tangential;
    default:
      return ParameterKind::radial;
  }
}

Model::Model(std::string_view name, LensType lens_type, std::vector<FreeParameter> free)
    : name_(name), lens_type_(lens_type), free_(std::move(free)) {}

std::span<const Model> Model::all() { return candidates(); }

const Model& Model::named(std::string_view name) {
  std::string known;
  for (const Model& model : candidates()) {
    if (model.name() == name) return model;
    known += (known.empty() ? "" : ", ") + std::string(model.name());
  }
  throw Error("model: must be one of " + known + "; got " + std::string(name));
}

const Model& Model::sibling(std::string_view name) const {
  return siblings_ ? siblings_->named(name) : named(name);
}

std::vector<const Model*> Model::siblings() const {
  if (siblings_) return siblings_->all();
  std::vector<const Model*> models;
  for (const Model& model : all()) models.push_back(&model);
  return models;
}

std::optional<Lens> Model::lens(std::span<const double> free_values, const ImageSize& size) const {
  assert(free_values.size() == free_.size());
  const Eigen::Vector2d centre = image_centre(size);
  switch (lens_type_) {
    case LensType::perspective:
      return make_lens<Perspective>(free_, free_values, held_, {1, 1, centre.x(), centre.y()});
    case LensType::fisheye:
      return make_lens<Fisheye>(free_, free_values, held_, {1, 1, centre.x(), centre.y()});
    case LensType::parallel:
      return make_lens<Parallel>(free_, free_values, held_, {1, 1, centre.x(), centre.y()});
  }
  return std::nullopt;
}

std::vector<double> Model::free_values(const Lens& lens) const {
  const std::span<const double> all = parameters(lens);
  std::vector<double> values;
  for (const FreeParameter& parameter : free_) {
    double sum = 0;
    for (const int k : parameter.lens_parameters) sum += all[static_cast<std::size_t>(k)];
    values.push_back(sum / static_cast<double>(parameter.lens_parameters.size()));
  }
  return values;
}

bool Model::contains(const Camera& camera) const {
  if (static_cast<std::size_t>(lens_type_) != camera.lens.index()) return false;
  const std::optional<Lens> same = lens(free_values(camera.lens), camera.image_size);
  return same && std::ranges::equal(parameters(*same), parameters(camera.lens));
}

HeldModels::HeldModels(const std::map<std::string, double>& values, LensType lens_type)
    : models_(Model::all().begin(), Model::all().end()) {
  constexpr int kNumCommon = 4;  // fx, fy, cx, cy
  const std::map<int, double> given = by_index(values, lens_type);
  for (Model& model : models_) {
    model.siblings_ = this;
    if (model.lens_type() == LensType::parallel) continue;
    for (const auto& [k, value] : given)
      if (k < kNumCommon || model.lens_type() == lens_type) model.held_[k] = value;
    std::erase_if(model.free_, [&](const FreeParameter& parameter) {
      const auto& sets = parameter.lens_parameters;
      const auto first = std::ranges::find_if(
          sets, [&](int k) { return given.contains(k) && model.held_.contains(k); });
      if (first == sets.end()) return false;
      for (const int k : sets) model.held_.emplace(k, given.at(*first));
      return true;
    });
  }
}

const Model& HeldModels::named(std::string_view name) const {
  const Model& plain = Model::named(name);  // throws for one that is not known
  const auto first = models_.begin() + (&plain - Model::all().data());
  const auto next = std::find_if(first, models_.end(), [&](const Model& model) {
    return model.lens_type() == plain.lens_type() && model.num_free() > 0;
  });
  return next == models_.end() ? *first : *next;
}

std::vector<const Model*> HeldModels::all() const {
  std::vector<const Model*> some;
  for (const Model& model : models_) {
    const bool is_weak = model.lens_type() == LensType::parallel;
    const bool is_new =
        std::ranges::none_of(some, [&](const Model* other) { return alike(*other, model); });
    if (is_weak || (model.num_free() > 0 && is_new)) some.push_back(&model);
  }
  return some;
}

}  // namespace tagcal
