// One depth by four conventions, back again, and what a buffer resolves.
#include <cstdio>
#include <tagcal/viewing/canonical.hpp>
#include <tagcal/viewing/projection.hpp>

int main() {
  const tagcal::ViewVolume volume{tagcal::Projection::perspective, {-0.4, 0.4, -0.3, 0.3}, 0.6, 3};
  const Eigen::Vector4d x_in_eye(0.25, 0.15, -1.2, 1);
  const auto depth = [&](tagcal::CanonicalVolume canonical) {
    return tagcal::divided(tagcal::clip_from_eye(volume, canonical) * x_in_eye)->z();
  };
  std::printf("OpenGL %.4f, PHIGS %.4f, 0 to 1 %.4f, reversed %.4f\n",
              depth(tagcal::CanonicalVolume::opengl), depth(tagcal::CanonicalVolume::phigs),
              depth(tagcal::CanonicalVolume::zero_to_one),
              depth(tagcal::CanonicalVolume::one_to_zero));
  std::printf("back: z %.4f m by OpenGL's, %.4f m by PHIGS'\n",
              tagcal::z_from_opengl_depth(0.25, 0.6, 3),
              tagcal::z_from_phigs_depth(-0.625, 0.6 / 3) * 3);
  for (const double near_m : {0.1, 1.0})
    std::printf("near %.1f m, far 1000 m, 24 bits: a step of %.3f mm at 100 m\n", near_m,
                1000 * tagcal::depth_resolution_m(-100, near_m, 1000, 24));
  for (const tagcal::NormalisingStep& step :
       tagcal::normalising_steps(volume, tagcal::CanonicalVolume::opengl))
    std::printf("%.*s\n", static_cast<int>(step.name.size()), step.name.data());
}
