#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

// How the corners of a decoded tag are made finer.
enum class Refinement {
  stock,  // as AprilTag gives them
  edges,  // each side of the tag fitted by itself: refine_edges.hpp
  fit,    // the whole printed pattern fitted (refine_tag.hpp), with covariances; where that fails,
          // under the lens that the tags of the picture show together; where that fails too, the
          // tag is not reported
};

struct DetectOptions {
  int threads = 0;      // working side by side, on pictures or in a single one; 0: one per core
  int max_hamming = 1;  // wrong bits accepted in a tag (0-2)
  Refinement refinement = Refinement::fit;
  // The camera of all pictures, if it is known; it must outlive the search. Tags are fitted under
  // its lens (TagFitOptions::camera), and without where that fails.
  const Camera* camera = nullptr;
};

// A tag that was read, but is not reported: its pattern could not be fitted.
struct UnfittedTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  // roughly, px
};

struct DetectResult {
  std::vector<View> views;  // in the order of the images; corners ordered by id
  std::vector<std::vector<UnfittedTag>> unfitted;  // of each view
  std::vector<std::string> warnings;               // in plain words; those of one image name it
};

// One image of a batch: its name and how to load it (called from a worker thread, may throw Error).
struct ImageSource {
  std::string name;
  std::function<Image8()> load;
};

// Finds the corners of the boards' tags in one picture. Tags of the family that are on none of the
// boards are left out, and said in `warnings`, as is a tag seen twice (both are left out). Pictures
// smaller than 8x8 hold no tag. Corners: pixel centres at whole numbers.
// Throws Error where the picture has not the size of the camera that is given.
View detect(const Image8& image, const std::string& name, const std::vector<PlacedBoard>& boards,
            const DetectOptions& options, std::vector<std::string>* warnings);

// The same for many pictures, several at once. The answer does not depend on the number of threads.
// Where the pictures show tags with another border than the boards say, the first warning says so.
// `progress(done, total)` is called from the calling thread's side, under a lock, after each image.
DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options,
                        const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
