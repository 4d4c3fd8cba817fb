#pragma once

#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/unified_sphere.hpp"

namespace tagcal::internal {

// The limit of the domain of each lens, as its kernel takes it.
inline double domain_limit(const Perspective& l) { return l.max_radius() * l.max_radius(); }
inline double domain_limit(const Fisheye& l) { return l.max_angle(); }
inline double domain_limit(const Parallel&) { return 0; }
inline double domain_limit(const DoubleSphere& l) { return UnifiedSphere{l.parameters()[5]}.w(); }
inline double domain_limit(const ExtendedUnified& l) {
  return UnifiedSphere{l.parameters()[4]}.w();
}

}  // namespace tagcal::internal
