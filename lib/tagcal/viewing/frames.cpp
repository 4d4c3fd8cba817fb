#include "tagcal/viewing/frames.hpp"

#include <algorithm>
#include <type_traits>

#include "tagcal/error.hpp"
#include "tagcal/internal/finite.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw Error("frames: '" + name + "' " + what);
}

template <typename Transform>
void check_finite(const std::string& name, const Transform& transform) {
  if (!transform.matrix().allFinite()) fail(name, "has a transform that is not finite");
}

Pose inverse_of_frame(const std::string& /*name*/, const Pose& pose) { return pose.inverse(); }

Affine inverse_of_frame(const std::string& name, const Affine& transform) {
  try {
    return inverse_of(transform);
  } catch (const Error&) {
    fail(name, "cannot be reached from outside: its transform has no inverse");
  }
}

template <typename Transform>
Transform identity() {
  if constexpr (std::is_same_v<Transform, Affine>)
    return Affine::Identity();
  else
    return Transform();
}

}  // namespace

template <typename Transform>
Frames<Transform>::Frames(const std::string& root) : Frames(root, {}) {}

template <typename Transform>
Frames<Transform>::Frames(const std::string& root, const std::vector<Frame<Transform>>& frames) {
  append({root, "", identity<Transform>()});
  for (const auto& frame : frames) append(frame);
  parents_.assign(frames_.size(), kRoot);
  for (std::size_t i = kRoot + 1; i < frames_.size(); ++i) parents_[i] = index(frames_[i].parent);
  for (std::size_t i = kRoot + 1; i < frames_.size(); ++i) refuse_cycle(i, parents_[i]);
}

template <typename Transform>
void Frames<Transform>::append(const Frame<Transform>& frame) {
  if (frame.name.empty()) throw Error("frames: a frame must have a name");
  check_finite(frame.name, frame.parent_from_frame);
  if (!index_.emplace(frame.name, frames_.size()).second) fail(frame.name, "is there twice");
  frames_.push_back(frame);
}

template <typename Transform>
void Frames<Transform>::add(const Frame<Transform>& frame) {
  const std::size_t parent = index(frame.parent);
  append(frame);
  parents_.push_back(parent);
}

template <typename Transform>
void Frames<Transform>::move(const std::string& name, const Transform& parent_from_frame) {
  move({name, parent(name), parent_from_frame});
}

template <typename Transform>
void Frames<Transform>::move(const Frame<Transform>& frame) {
  const std::size_t moved = index(frame.name);
  if (moved == kRoot) fail(frame.name, "is the root and hangs on no other frame");
  const std::size_t parent = index(frame.parent);
  check_finite(frame.name, frame.parent_from_frame);
  refuse_cycle(moved, parent);
  frames_[moved] = frame;
  parents_[moved] = parent;
}

template <typename Transform>
Transform Frames<Transform>::a_from_b(const std::string& a, const std::string& b) const {
  std::vector<std::size_t> from_a = way_to_root(index(a));
  std::vector<std::size_t> from_b = way_to_root(index(b));
  while (!from_a.empty() && !from_b.empty() && from_a.back() == from_b.back()) {
    from_a.pop_back();
    from_b.pop_back();
  }
  Transform result = identity<Transform>();
  for (const std::size_t i : from_a)
    result = result * inverse_of_frame(frames_[i].name, frames_[i].parent_from_frame);
  for (auto i = from_b.rbegin(); i != from_b.rend(); ++i)
    result = result * frames_[*i].parent_from_frame;
  return result;
}

template <typename Transform>
const std::string& Frames<Transform>::parent(const std::string& name) const {
  return frames_[index(name)].parent;
}

template <typename Transform>
std::vector<std::string> Frames<Transform>::names() const {
  std::vector<std::string> result;
  for (const auto& frame : frames_) result.push_back(frame.name);
  return result;
}

template <typename Transform>
std::size_t Frames<Transform>::index(const std::string& name) const {
  const auto found = index_.find(name);
  if (found == index_.end()) fail(name, "is no frame");
  return found->second;
}

// From the frame to the last one below the root.
template <typename Transform>
std::vector<std::size_t> Frames<Transform>::way_to_root(std::size_t frame) const {
  std::vector<std::size_t> way;
  for (; frame != kRoot; frame = parents_[frame]) way.push_back(frame);
  return way;
}

// There may be other cycles above, so the walk ends after one step per frame.
template <typename Transform>
void Frames<Transform>::refuse_cycle(std::size_t frame, std::size_t parent) const {
  std::string chain = "hangs on itself: " + frames_[frame].name;
  for (std::size_t step = 0; step < frames_.size() && parent != kRoot; ++step) {
    chain += " on " + frames_[parent].name;
    if (parent == frame) fail(frames_[frame].name, chain);
    parent = parents_[parent];
  }
}

template class Frames<Pose>;
template class Frames<Affine>;

void MatrixStack::multiply(const Pose& next) {
  const Affine matrix_of_next = affine(next);
  require_finite(matrix_of_next.matrix(), "matrix stack");
  levels_.back().matrix = levels_.back().matrix * matrix_of_next;
  levels_.back().inverse = affine(next.inverse()) * levels_.back().inverse;
}

void MatrixStack::multiply(const Affine& next) {
  const Affine inverse_of_next = inverse_of(next);
  levels_.back().matrix = levels_.back().matrix * next;
  levels_.back().inverse = inverse_of_next * levels_.back().inverse;
}

void MatrixStack::push() { levels_.push_back(Level(levels_.back())); }

void MatrixStack::pop() {
  if (levels_.size() == 1) throw Error("matrix stack: pop of an empty stack");
  levels_.pop_back();
}

Pose world_from_three_points(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  for (const Vector3d& point : {a, b, c}) require_finite(point, "frame of three points");
  const Vector3d ab = (b - a).stableNormalized(), ac = (c - a).stableNormalized();
  const Vector3d normal = ab.cross(ac);
  if (!(normal.norm() > 1e-9)) throw Error("frame of three points: the points are on a line");
  Eigen::Matrix3d axes;
  axes.col(0) = ac;
  axes.col(1) = normal.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return {Eigen::Quaterniond(axes), a};
}

}  // namespace tagcal
