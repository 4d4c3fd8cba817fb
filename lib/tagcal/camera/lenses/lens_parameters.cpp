#include "tagcal/camera/lenses/lens_parameters.hpp"

namespace tagcal {

Lens make_lens(const LensKind& kind, std::span<const double> parameters) {
  for (std::size_t i = 0; i < kind.parameters.size(); ++i)
    internal::check(kind.parameters[i], parameters[i]);
  return *kind.lens(parameters);
}

}  // namespace tagcal
