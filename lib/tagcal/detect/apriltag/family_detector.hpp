#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/refine.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/picture_terms.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// The tags to find, all of one family and border.
struct Wanted {
  std::string family;
  int border_bits = 1;
  std::set<int> ids;
  bool corner_squares = false;
  std::map<int, TagPattern> patterns;  // by id; tags without one are not fitted
  std::optional<TagFamily> any;        // if tags of every id are wanted: for their patterns
};

struct FoundTag {
  int id = 0;
  Quad corners;
  bool refined = false;
  bool is_approximate = false;         // seen in a halved or shrunk picture only: not yet a tag
  bool fitted = false;                 // then covariance_px2 is that of (x0, y0, x1, y1, ..)
  bool by_corner = false;              // fitted corner by corner, or approximate: to be fitted
  std::optional<Camera> rough_camera;  // the camera of the fit, if it had one and bends
  Eigen::Matrix<double, 8, 8> covariance_px2 = Eigen::Matrix<double, 8, 8>::Zero();
  std::optional<TagFitRest> rest;  // of a fit as a whole, without a rough camera
};

// True if all of a tag lies in the picture. A tag near the edge that was not fitted as a whole may
// be the rest of a cut one, so it needs a wider margin.
bool is_whole(const FoundTag& tag, const ImageSize& size);

// Number of times that a picture of this size is halved before it is searched first.
int num_halvings(const ImageSize& size);
// True if a picture of this size that shows no tag is searched after doubling it.
bool is_worth_doubling(const ImageSize& size);
// Throws Error unless a picture has the size of the given camera's, if there is one.
void check_size(const Camera* camera, const ImageSize& size, const std::string& name);

// A part of a picture to search, after halving it `halvings` times (-1: after doubling it), in one
// of the detector's passes.
struct Search {
  PixelBox box;
  int halvings = 0;
  std::size_t pass = 0;
};

// AprilTag's detector for one family and border. Not thread-safe.
class FamilyDetector {
 public:
  FamilyDetector(const Wanted& wanted, const DetectOptions& options);

  const Wanted& wanted() const { return wanted_; }

  // All tags of the family that lie whole in the picture, wanted or not. Precondition: 8x8 or more.
  std::vector<FoundTag> find(const ImageView8& image);

  // Number of passes over a picture. Each pass shrinks black more than the one before.
  std::size_t num_passes() const { return passes_.size(); }

  // Adds new tags to `found`. Tags seen in a halved picture are approximate if their edges cannot
  // be fitted in the picture itself.
  void find(const ImageView8& image, const Search& search, std::vector<FoundTag>& found);

  // Adds the approximate places of tags that are too large and too bent for AprilTag: they are
  // searched for in a straightened picture, under a roughly guessed lens.
  void find_bent(const ImageView8& image, const Lens& lens, std::vector<FoundTag>& found) const;

  // Refines a tag whose corners are known to 2 px; no value if neither its pattern nor its edges
  // can be fitted. Also refines the edges if the detector's refinement is `stock`.
  // A tag for a fit corner by corner is left unfitted if a fit under the picture's lens follows.
  std::optional<FoundTag> refined(const ImageView8& image, int id, const Quad& start,
                                  bool lens_follows = true) const;

  // The same for a tag of the picture before, at its predicted place in this one.
  std::optional<FoundTag> refined_again(const ImageView8& image, const FoundTag& before,
                                        const Quad& start) const;

  // Estimates the terms of a picture from its tags and fits these again with them. Later fits have
  // them too, until the next call of this or the next function. Returns false if there are none:
  // nothing was fitted.
  bool find_terms(const ImageView8& image, const std::vector<FoundTag*>& tags);
  const PictureTerms& terms() const { return terms_; }
  void set_terms(const PictureTerms& terms) { terms_ = terms; }

  // Fits a tag under a roughly known lens, from its present corners, good to `reach_px`. If the fit
  // fails, returns false and leaves the tag unchanged.
  bool fit_roughly(FoundTag& tag, const ImageView8& image, const Camera& camera,
                   double reach_px = policy::kTagMaxMovePx) const;

 private:
  struct Pass {
    int shrink = 0;  // px by which black is shrunk before AprilTag looks
    DetectorHandle detector;
  };

  void add(const ImageView8& image, int id, const Quad& corners, bool exact,
           std::vector<FoundTag>& found);
  bool fit(FoundTag& tag, const ImageView8& image, bool lens_follows) const;
  // With the picture's terms.
  bool fit(FoundTag& tag, const ImageView8& image, const TagFitOptions& options,
           double reach_px = policy::kTagMaxMovePx) const;
  Quad unhalved(const std::vector<Image8>& halves, Quad corners, bool is_shrunk) const;

  Wanted wanted_;
  int max_hamming_;
  std::shared_ptr<apriltag_family_t> family_;
  Refinement refinement_;
  const Camera* camera_;
  PictureTerms terms_;
  std::vector<Pass> passes_;
};

}  // namespace tagcal::internal
