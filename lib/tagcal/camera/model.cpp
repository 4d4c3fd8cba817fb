#include "tagcal/camera/model.hpp"

#include <array>
#include <cassert>
#include <cmath>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

const std::array<Model, 9>& ladder() {
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
  static const std::array<Model, 9> models = {
      Model("weak", LensType::parallel, {}),
      Model("f", LensType::perspective, {f}),
      Model("f+c", LensType::perspective, {f, cx, cy}),
      Model("pinhole", LensType::perspective, fxfycxcy),
      Model("radial1", LensType::perspective, {f, cx, cy, k1}),
      Model("radial2", LensType::perspective, {f, cx, cy, k1, k2}),
      Model("fisheye4", LensType::fisheye,
            with(fxfycxcy, {{"k1", {4}}, {"k2", {5}}, {"k3", {6}}, {"k4", {7}}})),
      Model("opencv5", LensType::perspective, with(fxfycxcy, {k1, k2, p1, p2, k3})),
      Model("opencv8", LensType::perspective, with(fxfycxcy, {k1, k2, p1, p2, k3, k4, k5, k6}))};
  return models;
}

template <typename L>
std::optional<Lens> make_lens(const std::vector<FreeParameter>& free,
                              std::span<const double> values, typename L::Parameters parameters) {
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (!std::isfinite(values[i])) return std::nullopt;
    for (const int k : free[i].lens_parameters) parameters[static_cast<std::size_t>(k)] = values[i];
  }
  if (!(parameters[0] > 0 && parameters[1] > 0)) return std::nullopt;
  return Lens(L(parameters));
}

}  // namespace

Model::Model(std::string_view name, LensType lens_type, std::vector<FreeParameter> free)
    : name_(name), lens_type_(lens_type), free_(std::move(free)) {}

std::span<const Model> Model::all() { return ladder(); }

const Model& Model::named(std::string_view name) {
  std::string known;
  for (const Model& model : ladder()) {
    if (model.name() == name) return model;
    known += (known.empty() ? "" : ", ") + std::string(model.name());
  }
  throw Error("model: must be one of " + known + "; got " + std::string(name));
}

std::optional<Lens> Model::lens(std::span<const double> free_values, const ImageSize& size) const {
  assert(free_values.size() == free_.size());
  const Eigen::Vector2d centre = image_centre(size);
  switch (lens_type_) {
    case LensType::perspective:
      return make_lens<Perspective>(free_, free_values, {1, 1, centre.x(), centre.y()});
    case LensType::fisheye:
      return make_lens<Fisheye>(free_, free_values, {1, 1, centre.x(), centre.y()});
    case LensType::parallel:
      return make_lens<Parallel>(free_, free_values, {1, 1, centre.x(), centre.y()});
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

}  // namespace tagcal
