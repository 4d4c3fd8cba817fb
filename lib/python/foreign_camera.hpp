#pragma once

#include "tagcal/camera/foreign_lens.hpp"

namespace tagcal::python {

// A camera with a lens that tagcal does not estimate.
struct ForeignCamera {
  ForeignLens lens;
  ImageSize image_size;
};

}  // namespace tagcal::python
