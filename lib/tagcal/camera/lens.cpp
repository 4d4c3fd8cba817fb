#include "tagcal/camera/lens.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace tagcal {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

template <typename L>
constexpr auto names_of() {
  std::array<std::string_view, L::kNumParameters> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = L::kParameters[i].name;
  return names;
}

template <typename L>
constexpr auto kNames = names_of<L>();

template <typename L>
std::optional<Lens> lens_of(std::span<const double> values) {
  typename L::Parameters parameters = {};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (!L::kParameters[i].holds(values[i])) return std::nullopt;
    parameters[i] = values[i];
  }
  return Lens(L(parameters));
}

template <std::size_t... kIndex>
constexpr auto rows(std::index_sequence<kIndex...>) {
  const auto row = []<typename L>(std::in_place_type_t<L>) {
    return LensKind{L::kName,      L::kParameters,    kNames<L>,
                    L::kIsCentral, L::kReachesBehind, lens_of<L>};
  };
  return std::array{row(std::in_place_type<std::variant_alternative_t<kIndex, Lens>>)...};
}

constexpr auto kKinds = rows(std::make_index_sequence<std::variant_size_v<Lens>>());

}  // namespace

std::span<const LensKind> lens_kinds() { return kKinds; }

const LensKind& kind_of(const Lens& lens) { return kKinds[lens.index()]; }

template <typename L>
const LensKind& kind_of() {
  return *std::ranges::find(kKinds, L::kName, &LensKind::name);
}
template const LensKind& kind_of<Perspective>();
template const LensKind& kind_of<Fisheye>();
template const LensKind& kind_of<Parallel>();
template const LensKind& kind_of<DoubleSphere>();
template const LensKind& kind_of<ExtendedUnified>();

Lens plain_lens(const LensKind& kind, double focal_px, const Vector2d& centre) {
  std::vector<double> values;
  for (const LensParameter& parameter : kind.parameters) values.push_back(parameter.plain);
  for (const std::size_t i : {0, 1}) {
    values[i] *= focal_px;
    values[i + 2] = centre[static_cast<Eigen::Index>(i)];
  }
  return *kind.lens(values);
}

std::span<const double> parameters(const Lens& lens) {
  return std::visit([](const auto& l) { return std::span<const double>(l.parameters()); }, lens);
}

std::span<const std::string_view> parameter_names(const Lens& lens) {
  return kind_of(lens).parameter_names;
}

bool in_domain(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.in_domain(x_in_camera); }, lens);
}

double max_angle(const Lens& lens) {
  return std::visit(
      [](const auto& l) {
        if constexpr (requires { l.max_angle(); }) return l.max_angle();
        return std::numeric_limits<double>::quiet_NaN();
      },
      lens);
}

Vector2d focal_lengths_px(const Lens& lens) {
  PointJacobian by_point;
  std::visit([&](const auto& l) { l.project(Vector3d::UnitZ(), &by_point, nullptr); }, lens);
  return {by_point(0, 0), by_point(1, 1)};
}

std::optional<Vector2d> project(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.project(x_in_camera); }, lens);
}

std::optional<Ray> ray_in_camera(const Lens& lens, const Vector2d& pixel) {
  return std::visit([&](const auto& l) { return l.ray_in_camera(pixel); }, lens);
}

}  // namespace tagcal
