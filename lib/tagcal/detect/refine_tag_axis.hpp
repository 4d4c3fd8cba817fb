#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

// Private to detect: one direction of the grid that refine_tag() fits, seen along a row of pixels.
namespace tagcal {

constexpr int kMaxTagLines = 24;

// Where the pixels of a row are before the homography, by their number.
struct RowPlaces {
  const float* x = nullptr;
  const float* y = nullptr;
  double bulge = 0;  // how far they stray from a straight line with even steps, at most
  // Squares and product of the slopes of x and y over the picture, in px per px, where places are
  // stretched against pixels; and their largest stretch.
  const float* xx = nullptr;
  const float* xy = nullptr;
  const float* yy = nullptr;
  double stretch = 1;
};

// A border between cells, as a line in the image.
struct TagLine {
  double at = 0;                                     // on the tag
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // towards larger places on the tag
  double inv_length = 0;                             // of the line's normal part
  double inv_spread = 0;  // distance in spreads = inv_spread (numerator - at denominator)
  double box = 0;         // fourth cumulant of the pixel's square over 24 spread^4

  // For the loop over pixels.
  struct Single {
    float at = 0, normal_x = 0, normal_y = 0, inv_spread = 0;
    float by_x = 0, by_y = 0, by_1 = 0;  // of the distance in spreads

    float distance(float x, float y) const { return by_x * x + by_y * y + by_1; }
  };
  Single single;
};

// The profiles of all lines' steps along one row of pixels, where they are felt.
class TagAxis {
 public:
  static constexpr float kReach = 3.8F;       // spreads at which a line is felt: 1e-4 of the step
  static constexpr double kUnknownReach = 3;  // and beyond which the unknown is not: 0.14 % of it

  explicit TagAxis(const std::vector<double>& places);
  TagAxis(const TagAxis&) = delete;  // profiles point into it
  TagAxis& operator=(const TagAxis&) = delete;

  std::vector<TagLine> lines;

  // Shrinks [begin, end) to the pixels that the unknown, beyond the outermost lines, does not
  // reach: those nearer than `reach` spreads to it.
  void clip(const RowPlaces& places, double reach, int& begin, int& end) const;
  void set_row(const RowPlaces& places, int begin, int end);

  // Lines [first, first + count) are felt at pixel c; before the first lies cell first - 1.
  int first(int c) const { return first_[static_cast<std::size_t>(c)]; }
  int count(int c) const { return count_[static_cast<std::size_t>(c)]; }

  // For a line that is felt at a pixel: its distance in spreads, the Gaussian's density there, the
  // step with the pixel's square and its derivative by the distance; and px per stretched px.
  struct Profile {
    float* distance = nullptr;
    float* density = nullptr;
    float* step = nullptr;
    float* slope = nullptr;
    float* factor = nullptr;
  };
  const Profile& profile(int line) const { return profiles_[static_cast<std::size_t>(line)]; }

 private:
  void reserve(std::size_t size);
  void set_line(int line, const RowPlaces& places, int begin, int end);

  std::vector<Profile> profiles_;  // within values_
  std::vector<float> values_;
  std::vector<std::uint8_t> first_, count_;
};

}  // namespace tagcal
