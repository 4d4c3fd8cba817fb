#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::internal {
namespace {

// Builds a tree from yaml-cpp's events: yaml-cpp's own tree accepts duplicate keys silently, and
// its recursion has no limit.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::string& file) : file_(file) {}

  std::shared_ptr<const YamlNode> root() const { return root_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (root_) fail(mark, "a second YAML document begins, but a file has one");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (waits_for_key()) return take_key(mark, "");
    place(mark, anchor, std::make_shared<YamlNode>());
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (waits_for_key()) fail(mark, "a key must be plain text");
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) fail(mark, "an alias is inside its own anchor");
    count(mark);
    check_depth(mark, found->second.height);
    attach(mark, found->second.node, found->second.height);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    if (waits_for_key()) return take_key(mark, value);
    auto node = std::make_shared<YamlNode>();
    node->kind = YamlNode::Kind::scalar;
    node->quoted = tag == "!";
    node->scalar = value;
    place(mark, anchor, std::move(node));
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, YamlNode::Kind::list);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, YamlNode::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    std::shared_ptr<YamlNode> node;
    YAML::anchor_t anchor;
    std::optional<std::string> key;  // of the next value
    std::set<std::string> keys;
    int height = 1;  // levels of the value, its aliases followed
  };
  struct Anchored {
    std::shared_ptr<const YamlNode> node;
    int height = 0;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& message) const {
    throw Error(fmt::format("{}: line {}: {}", file_, mark.line + 1, message));
  }

  bool waits_for_key() const {
    return !open_.empty() && open_.back().node->kind == YamlNode::Kind::map && !open_.back().key;
  }

  void take_key(const YAML::Mark& mark, const std::string& key) {
    if (!open_.back().keys.insert(key).second) {
      fail(mark, fmt::format("{}: the key is given twice", shown(key)));
    }
    open_.back().key = key;
  }

  void count(const YAML::Mark& mark) {
    if (++num_nodes_ > limits::kMaxYamlValues) fail(mark, "more than 2 million values");
  }

  // Aliases of aliases nest a value as brackets do: what walks the tree, and its destructor,
  // recurses once a level.
  void check_depth(const YAML::Mark& mark, int height) const {
    if (std::ssize(open_) + height > limits::kMaxYamlDepth)
      fail(mark, fmt::format("nested more than {} levels deep", limits::kMaxYamlDepth));
  }

  void attach(const YAML::Mark& mark, std::shared_ptr<const YamlNode> node, int height) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    parent.height = std::max(parent.height, height + 1);
    if (parent.node->kind == YamlNode::Kind::map && !parent.key) {
      fail(mark, "a key must be plain text");
    }
    parent.node->children.emplace_back(parent.key.value_or(""), std::move(node));
    parent.key.reset();
  }

  void place(const YAML::Mark& mark, YAML::anchor_t anchor, std::shared_ptr<YamlNode> node) {
    count(mark);
    if (anchor != 0) anchors_[anchor] = {node, 0};
    attach(mark, std::move(node), 0);
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, YamlNode::Kind kind) {
    count(mark);
    check_depth(mark, 1);
    auto node = std::make_shared<YamlNode>();
    node->kind = kind;
    attach(mark, node, 1);
    open_.push_back({std::move(node), anchor, {}, {}});
  }

  void close() {
    const Open closed = std::move(open_.back());
    open_.pop_back();
    if (closed.anchor != 0) anchors_[closed.anchor] = {closed.node, closed.height};
    if (!open_.empty()) open_.back().height = std::max(open_.back().height, closed.height + 1);
  }

  const std::string& file_;
  std::shared_ptr<const YamlNode> root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  int num_nodes_ = 0;
};

}  // namespace

std::shared_ptr<const YamlNode> parse_yaml(const std::string& text, const std::string& file) {
  if (text.size() > limits::kMaxYamlBytes) throw Error(file + ": larger than 16 MiB");
  if (text.find('\0') != std::string::npos) throw Error(file + ": is not YAML: binary data");
  std::istringstream in(text);
  TreeBuilder builder(file);
  try {
    YAML::Parser parser(in);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const std::string line =
        error.mark.is_null() ? "" : fmt::format("line {}: ", error.mark.line + 1);
    throw Error(file + ": " + line + "is not YAML: " + shown(error.msg));
  }
  if (!builder.root()) throw Error(file + ": is empty");
  return builder.root();
}

}  // namespace tagcal::internal
