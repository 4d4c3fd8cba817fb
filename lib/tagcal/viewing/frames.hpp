#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/geometry/transform.hpp"

// Hierarchies of frames, for example a cup on a table in a room.

namespace tagcal {

// A frame and its transform to its parent frame.
template <typename Transform>
struct Frame {
  std::string name;
  std::string parent;
  Transform parent_from_frame;
};

// A tree of named frames under one root, and the transform between any two of them. With Transform
// = Pose all are rigid, with Affine they may stretch and shear (affine(pose) converts a rigid one).
// Every function throws Error, and leaves the tree unchanged, for a name that is empty, unknown or
// already used, for numbers that are not finite, and for a frame that would be its own ancestor.
template <typename Transform>
class Frames {
 public:
  explicit Frames(const std::string& root);

  // The frames may come in any order.
  Frames(const std::string& root, const std::vector<Frame<Transform>>& frames);

  // Adds a frame to a parent that exists.
  void add(const Frame<Transform>& frame);

  // Moves a frame, with all its descendants, in its parent or to another parent. Not the root.
  void move(const std::string& name, const Transform& parent_from_frame);
  void move(const Frame<Transform>& frame);

  // The transform by way of the nearest common ancestor, so that two cups on a table have an exact
  // relative transform however far away the world's origin is. Affine: throws Error if a transform
  // on the path down to `a` has no inverse.
  Transform a_from_b(const std::string& a, const std::string& b) const;

  // Empty for the root.
  const std::string& parent(const std::string& name) const;

  // The names in the order of addition, the root first.
  std::vector<std::string> names() const;

 private:
  std::size_t index(const std::string& name) const;
  void append(const Frame<Transform>& frame);
  std::vector<std::size_t> way_to_root(std::size_t frame) const;
  void refuse_cycle(std::size_t frame, std::size_t parent) const;

  static constexpr std::size_t kRoot = 0;  // its parent is itself
  std::vector<Frame<Transform>> frames_;
  std::vector<std::size_t> parents_;
  std::map<std::string, std::size_t> index_;
};

extern template class Frames<Pose>;
extern template class Frames<Affine>;

// The product of the transforms on the path through a hierarchy, with its inverse. On a path from
// the world to an object, matrix() is world_from_object.
class MatrixStack {
 public:
  const Affine& matrix() const { return levels_.back().matrix; }
  const Affine& inverse() const { return levels_.back().inverse; }

  // matrix() <- matrix() * next. Throws Error for an affine without an inverse.
  void multiply(const Pose& next);
  void multiply(const Affine& next);

  void push();  // remembers matrix()
  void pop();   // restores the last remembered matrix; throws Error if there is none

 private:
  struct Level {
    Affine matrix = Affine::Identity();
    Affine inverse = Affine::Identity();
  };
  std::vector<Level> levels_{1};
};

// The frame of three points: its origin is a, c lies on its +x axis, and its y axis is the normal
// (b - a) x (c - a); so b has y = 0 and z > 0. Throws Error if the points are on a line (to within
// 1e-9 rad).
Pose world_from_three_points(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c);

}  // namespace tagcal
