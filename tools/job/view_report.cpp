#include "job/view_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "job/view_values.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

// Visits the hierarchy from its root, as a renderer does.
class Visitor {
 public:
  explicit Visitor(const ViewReport& report) : report_(report) {
    for (const std::string& name : report.frames.names())
      if (const std::string& parent = report.frames.parent(name); !parent.empty())
        children_[parent].push_back(name);
    for (std::size_t b = 0; b < report.boards.size(); ++b)
      boards_[report.boards[b].frame].push_back(b);
  }

  std::vector<ShownFrame> all() {
    visit(kWorldFrame, {});
    return std::move(shown_);
  }

 private:
  void visit(const std::string& name, std::optional<std::size_t> index) {
    for (const std::size_t b : boards_[name]) {
      enter(fmt::format("board {}", b), index, report_.boards[b].board.world_from_board);
      shown_.back().board = b;
      stack_.pop();
    }
    for (const std::string& child : children_[name]) {
      enter(child, index, report_.frames.a_from_b(name, child));
      visit(child, shown_.size() - 1);
      stack_.pop();
    }
  }

  template <typename Transform>  // Pose or Affine
  void enter(const std::string& name, std::optional<std::size_t> parent,
             const Transform& parent_from_frame) {
    stack_.push();
    stack_.multiply(parent_from_frame);
    shown_.push_back({name,
                      parent,
                      {},
                      Affine::Identity() * parent_from_frame,
                      stack_.matrix(),
                      stack_.inverse()});
  }

  const ViewReport& report_;
  std::map<std::string, std::vector<std::string>> children_;
  std::map<std::string, std::vector<std::size_t>> boards_;
  MatrixStack stack_;
  std::vector<ShownFrame> shown_;
};

}  // namespace

std::string planes_beyond(const ViewReport& report) {
  const auto planes = clip_planes(report.pipeline.clip_from_eye);
  std::string text;
  for (std::size_t i = 0; i < planes.size() && !report.followed.in_volume; ++i)
    if (planes[i].height(report.followed.in_eye) < 0)
      text += (text.empty() ? "" : " and ") + std::string(kPlaneNames[i]);
  return text;
}

std::string pinhole_note(const ViewReport& report) {
  const Camera& camera = report.pipeline.camera;
  const auto pinhole = field_of_view(undistorted(camera)), lens = field_of_view(camera);
  if (!kind_of(camera.lens).reaches_behind || !pinhole) return "";
  return fmt::format(
             "rows clip, ndc, raster: of the pinhole with the same focal length on the axis, "
             "{:.0f} "
             "deg across",
             degrees(pinhole->horizontal_rad)) +
         (lens ? fmt::format("; the lens sees {:.0f} deg", degrees(lens->horizontal_rad)) : "");
}

std::string sight_line(const FollowedPoint& f) {
  return f.hidden_by.empty() ? std::string(sight_text(f.sight))
                             : "not seen: hidden by " + f.hidden_by;
}

std::vector<ShownFrame> shown_frames(const ViewReport& report) { return Visitor(report).all(); }

std::vector<ShownFrame> frames_of_board(const ViewReport& report, std::size_t board) {
  const std::vector<ShownFrame> all = shown_frames(report);
  std::vector<ShownFrame> chain;
  const ShownFrame* frame = &*std::ranges::find(all, std::optional(board), &ShownFrame::board);
  for (; frame; frame = frame->parent ? &all[*frame->parent] : nullptr) chain.push_back(*frame);
  std::ranges::reverse(chain);
  return chain;
}

}  // namespace tagcal::tools
