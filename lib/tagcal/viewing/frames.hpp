#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/geometry/transform.hpp"

// Hierarchies of frames: a cup on a table in a room, a wheel with something on its spoke.

namespace tagcal {

// A frame that hangs on another: coordinates in it become coordinates in its parent.
template <typename Transform>
struct Frame {
  std::string name;
  std::string parent;
  Transform parent_from_frame;
};

// Frames by their names, each on its parent, all on one root; the transform from any to any. With
// Transform = Pose all are rigid, with Affine they may stretch and shear (affine(pose) hangs a
// rigid one among them). Every function throws Error for a name that is empty, unknown, or taken by
// another frame, for numbers that are not finite, and for a frame that would hang on itself, and
// leaves the hierarchy as it was.
template <typename Transform>
class Frames {
 public:
  explicit Frames(const std::string& root);

  // In any order.
  Frames(const std::string& root, const std::vector<Frame<Transform>>& frames);

  // A new frame on one that is there.
  void add(const Frame<Transform>& frame);

  // A frame that is there, moved in its parent or to another one, with all that hangs on it. Not
  // the root.
  void move(const std::string& name, const Transform& parent_from_frame);
  void move(const Frame<Transform>& frame);

  // Through the nearest frame on which both hang, so that two cups on a table know each other
  // exactly however far away the world's origin is. Affine: throws Error where the way down to `a`
  // has no inverse.
  Transform a_from_b(const std::string& a, const std::string& b) const;

  // Empty for the root.
  const std::string& parent(const std::string& name) const;

  // In the order in which they came, the root first.
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

// For those who walk a hierarchy and keep where they are: the product of all that was multiplied on
// since the start, with its inverse beside it. Walking from the world to an object, matrix() is
// world_from_object.
class MatrixStack {
 public:
  const Affine& matrix() const { return levels_.back().matrix; }
  const Affine& inverse() const { return levels_.back().inverse; }

  // matrix() <- matrix() * next. Throws Error for an affine without an inverse.
  void multiply(const Pose& next);
  void multiply(const Affine& next);

  void push();  // remembers matrix()
  void pop();   // goes back to what was remembered last; Error where nothing is
  std::size_t num_pushed() const { return levels_.size() - 1; }

 private:
  struct Level {
    Affine matrix = Affine::Identity();
    Affine inverse = Affine::Identity();
  };
  std::vector<Level> levels_{1};
};

// The frame of three points: its origin is a, c lies on its +x axis, and its y axis is the normal
// (b - a) x (c - a); so b has y = 0 and z > 0. Throws Error where the points are on a line (to
// within 1e-9 rad).
Pose world_from_three_points(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c);

}  // namespace tagcal
