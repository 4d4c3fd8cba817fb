#include "job/view_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

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
