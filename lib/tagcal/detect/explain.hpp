#pragma once

#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

// Tags of one kind in a picture.
struct SeenKind {
  std::string family;
  int border_bits = 1;
  std::vector<int> ids;  // ascending; one seen twice stands twice
};

struct NotReported {
  int id = 0;
  std::string why;
};

// What a picture shows, and why not more.
struct Explanation {
  ImageSize size;
  int quads = 0;                          // black shapes with four sides, tags or not
  std::vector<SeenKind> decoded;          // of every family and border that is known
  std::vector<int> reported;              // ids of the boards' tags that detect() reports
  std::vector<NotReported> not_reported;  // ids of the boards, by id
  std::vector<std::string> mistakes;      // what is probably wrong with target or picture
};

// Looks at a picture with all families and borders, in a mirror and inverted, and at the spacing of
// the tags found: about ten times the work of detect(), for a person who wonders.
Explanation explain(const Image8& image, const std::vector<PlacedBoard>& boards);

}  // namespace tagcal
