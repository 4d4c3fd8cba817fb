// refine_tag where no tag is: any start on any picture ends in a status, and what converged is
// finite.

#include <gtest/gtest.h>

#include <cmath>

#include "false_tag_pictures.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Quad = std::array<Vector2d, 4>;

// From nearly square to folded over; some leave the picture.
Quad random_quad(const Image8& image, Random& random) {
  const Vector2d middle(random.uniform(-5, image.width() + 5.0),
                        random.uniform(-5, image.height() + 5.0));
  const double side = 4 * std::pow(50.0, random.uniform());
  const double turn = random.uniform(0, 7), bent = random.uniform(0, 0.8);
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    const double angle = turn - 1.5707963 * static_cast<double>(i);
    quad[i] = middle + 0.7 * side * Vector2d(std::cos(angle), std::sin(angle)) +
              bent * side * Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
  }
  return quad;
}

void expect_whole(const TagFit& fit) {
  if (fit.status != TagFitStatus::converged) return;
  for (const Vector2d& corner : fit.corners) EXPECT_TRUE(corner.allFinite());
  EXPECT_TRUE(fit.covariance_px2.allFinite());
  for (int i = 0; i < 8; ++i) EXPECT_GT(fit.covariance_px2(i, i), 0);
}

TEST(RefineTag, AnyStartOnAnyPictureEndsInAStatus) {
  for (const char* name : {"tag16h5", "tag36h11", "tagStandard41h12"}) {
    const TagFamily family = tag_family(name, 1);
    Random random(17);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Image8 image = picture_without_tags(seed);
      for (int i = 0; i < 30; ++i) {
        const TagPattern pattern =
            tag_pattern(family, static_cast<int>(random.index(family.codes.size())), 1);
        expect_whole(refine_tag(image, pattern, random_quad(image, random)));
      }
    }
  }
}

}  // namespace
}  // namespace tagcal
