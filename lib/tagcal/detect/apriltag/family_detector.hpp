#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/detect/tag_fit/refine_edges.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// The tags looked for with one family and border.
struct Wanted {
  std::string family;
  int border_bits = 1;
  std::set<int> ids;
  bool corner_squares = false;
  std::map<int, TagPattern> patterns;  // by id: what is not here is not fitted
};

struct FoundTag {
  int id = 0;
  Quad corners;
  bool refined = false;
  bool fitted = false;                 // then the covariance of (x0, y0, x1, y1, ..) is known
  bool by_corner = false;              // fitted corner by corner
  std::optional<Camera> rough_camera;  // under which it was fitted, with bends
  Eigen::Matrix<double, 8, 8> covariance_px2 = Eigen::Matrix<double, 8, 8>::Zero();
};

// Whether all of a tag lies in a picture. What is found along the edge of the picture and was not
// fitted as a whole may be what is left of a tag that it cuts.
bool is_whole(const FoundTag& tag, const ImageSize& size);

// What is searched for tags: a part of a picture, halved so many times before; -1: doubled.
struct Search {
  PixelBox box;
  int halvings = 0;
};

// AprilTag's detector for one family and border. Not for several threads at once; it may use some
// itself, which do not change the answer.
class FamilyDetector {
 public:
  FamilyDetector(const Wanted& wanted, const DetectOptions& options, int threads = 1);

  const Wanted& wanted() const { return wanted_; }

  // All tags of the family whole in the picture, wanted or not, which must be 8x8 at least.
  std::vector<FoundTag> find(const Image8& image);

  // Adds to `found` what a search shows beyond it. Of a halved picture only tags whose edges can
  // be fitted in the picture itself are found.
  void find(const Image8& image, const Search& search, std::vector<FoundTag>& found);

  // Four-sided black shapes in the last picture, tags or not.
  int num_quads() const { return num_quads_; }

  // A tag known to be there, its corners to 2 px; no value where the picture does not let them be
  // found. Stock corners are made finer by their edges here.
  std::optional<FoundTag> refined(const Image8& image, int id, const Quad& start);

  // The gamma of a picture's grey levels from tags that were found, which are fitted again with it;
  // it holds until the next call of this.
  // False where it is 1, and nothing is fitted again.
  bool find_gamma(const Image8& image, const std::vector<FoundTag*>& tags);
  void forget_gamma() { gamma_ = 1; }

  // Fits a tag from its corners as they are, to 2 px, under a lens that is known roughly. False
  // where that fails: then the tag is as it was.
  bool fit_roughly(FoundTag& tag, const Image8& image, const Camera& camera) const;

 private:
  struct Pass {
    int shrink = 0;  // px, of black, before AprilTag looks
    DetectorHandle detector;
  };
  struct Sighting {
    int id = 0;
    Quad corners;
  };

  static std::vector<Sighting> look(const Image8& searched, const Pass& pass, int max_hamming);
  std::vector<std::vector<Sighting>> look(const Image8& searched) const;
  void add(const Image8& image, const Sighting& sighting, bool exact, std::vector<FoundTag>& found);
  bool fit(FoundTag& tag, const Image8& image) const;
  bool fit(FoundTag& tag, const Image8& image, const Camera* camera, bool is_rough) const;
  Quad unhalved(const std::vector<Image8>& halves, Quad corners) const;

  Wanted wanted_;
  FamilyHandle family_;
  int max_hamming_;
  int threads_;
  Refinement refinement_;
  const Camera* camera_;
  double gamma_ = 1;
  std::vector<Pass> passes_;
  int num_quads_ = 0;
};

}  // namespace tagcal::internal
