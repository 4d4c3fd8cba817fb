#include "tagcal/camera/model.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
namespace {

using enum ModelRole;

std::span<const Model> candidates() {
  static const LensKind &perspective = kind_of<Perspective>(), &fisheye = kind_of<Fisheye>();
  static const std::array models = {
      Model("weak", kind_of<Parallel>(), {}, largest),
      Model("f", perspective, {"f"}),
      Model("f+c", perspective, {"f", "cx", "cy"}),
      Model("pinhole", perspective, {"fx", "fy", "cx", "cy"}),
      Model("radial1", perspective, {"f", "cx", "cy", "k1"}),
      Model("radial2", perspective, {"f", "cx", "cy", "k1", "k2"}),
      Model("ds", kind_of<DoubleSphere>(), {"fx", "fy", "cx", "cy", "xi", "alpha"}, largest),
      Model("eucm", kind_of<ExtendedUnified>(), {"fx", "fy", "cx", "cy", "alpha", "beta"}, largest),
      Model("opencv4", perspective, {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}),
      Model("fisheye4", fisheye, {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"}, largest),
      Model("opencv5", perspective, {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}, usual),
      Model("opencv8", perspective,
            {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}, largest)};
  return models;
}

// Index of a lens parameter; no value for an unknown name.
std::optional<int> index_of(std::string_view name, const LensKind& kind) {
  const auto at = std::ranges::find(kind.parameters, name, &LensParameter::name);
  if (at == kind.parameters.end()) return std::nullopt;
  return static_cast<int>(at - kind.parameters.begin());
}

// The held values by parameter index of the lens.
std::map<int, double> by_index(const std::map<std::string, double>& values, const LensKind& kind) {
  std::map<int, double> held;
  for (const auto& [name, value] : values) {
    const std::optional<int> index = name == "f" ? 0 : index_of(name, kind);
    if (!index) {
      std::string known = "f";
      for (const LensParameter& p : kind.parameters) known += ", " + std::string(p.name);
      throw Error("fixed: must be one of " + known + "; got " + name);
    }
    const LensParameter& parameter = kind.parameters[static_cast<std::size_t>(*index)];
    if (!parameter.holds(value))
      throw Error("fixed: " + name + " must be " + internal::range_text(parameter) + ", got " +
                  internal::short_number(value));
    bool is_new = held.emplace(*index, value).second;
    if (name == "f") is_new &= held.emplace(1, value).second;
    if (!is_new) throw Error("fixed: " + name + " is held twice");
  }
  return held;
}

bool alike(const Model& a, const Model& b) {
  return &a.kind() == &b.kind() && a.held() == b.held() &&
         std::ranges::equal(a.free(), b.free(), {}, &FreeParameter::lens_parameters,
                            &FreeParameter::lens_parameters);
}

}  // namespace

Model::Model(std::string_view name, const LensKind& kind,
             std::initializer_list<std::string_view> free, ModelRole role)
    : name_(name), kind_(&kind), role_(role) {
  for (const std::string_view parameter : free)
    free_.push_back({parameter, parameter == "f" ? std::vector{0, 1}
                                                 : std::vector{*index_of(parameter, kind)}});
}

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

const Model& Model::sibling(const LensKind& kind, ModelRole role) const {
  if (siblings_) return siblings_->of(kind, role);
  return *std::ranges::find_if(
      candidates(), [&](const Model& m) { return &m.kind() == &kind && m.role() >= role; });
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
  std::vector<double> values;
  for (const LensParameter& parameter : kind_->parameters) values.push_back(parameter.plain);
  values[2] = centre.x();
  values[3] = centre.y();
  for (const auto& [k, value] : held_) values[static_cast<std::size_t>(k)] = value;
  for (std::size_t i = 0; i < free_.size(); ++i)
    for (const int k : free_[i].lens_parameters)
      values[static_cast<std::size_t>(k)] = free_values[i];
  return kind_->lens(values);
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
  if (kind_ != &kind_of(camera.lens)) return false;
  const std::optional<Lens> same = lens(free_values(camera.lens), camera.image_size);
  return same && std::ranges::equal(parameters(*same), parameters(camera.lens));
}

HeldModels::HeldModels(const std::map<std::string, double>& values, const LensKind& kind)
    : models_(Model::all().begin(), Model::all().end()) {
  constexpr int kNumCommon = 4;  // fx, fy, cx, cy
  const std::map<int, double> given = by_index(values, kind);
  for (Model& model : models_) {
    model.siblings_ = this;
    if (!model.kind().is_central) continue;
    for (const auto& [k, value] : given)
      if (k < kNumCommon || &model.kind() == &kind) model.held_[k] = value;
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
    return &model.kind() == &plain.kind() && model.num_free() > 0;
  });
  return next == models_.end() ? *first : *next;
}

const Model& HeldModels::of(const LensKind& kind, ModelRole role) const {
  return named(Model::all().front().sibling(kind, role).name());
}

std::vector<const Model*> HeldModels::all() const {
  std::vector<const Model*> some;
  for (const Model& model : models_) {
    const bool is_weak = !model.kind().is_central;
    const bool is_new =
        std::ranges::none_of(some, [&](const Model* other) { return alike(*other, model); });
    if (is_weak || (model.num_free() > 0 && is_new)) some.push_back(&model);
  }
  return some;
}

const Model& full_model(const Lens& lens) {
  const LensKind& kind = kind_of(lens);
  const std::span<const double> values = parameters(lens);
  const Model& usual = candidates().front().sibling(kind, ModelRole::usual);
  for (std::size_t i = 4; i < values.size(); ++i) {
    const auto sets = [&](const FreeParameter& free) {
      return free.lens_parameters.front() == static_cast<int>(i);
    };
    if (values[i] != kind.parameters[i].plain && std::ranges::none_of(usual.free(), sets))
      return candidates().front().sibling(kind, ModelRole::largest);
  }
  return usual;
}

}  // namespace tagcal
