#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "tagcal/error.hpp"
#include "tagcal/io/text/number_text.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMaxSize = std::size_t{16} << 20;
constexpr std::size_t kMaxDepth = 64;
constexpr int kMaxNodes = 2'000'000;

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
    attach(mark, found->second);
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
    if (++num_nodes_ > kMaxNodes) fail(mark, "more than 2 million values");
  }

  void attach(const YAML::Mark& mark, std::shared_ptr<const YamlNode> node) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    if (parent.node->kind == YamlNode::Kind::map && !parent.key) {
      fail(mark, "a key must be plain text");
    }
    parent.node->children.emplace_back(parent.key.value_or(""), std::move(node));
    parent.key.reset();
  }

  void place(const YAML::Mark& mark, YAML::anchor_t anchor, std::shared_ptr<YamlNode> node) {
    count(mark);
    if (anchor != 0) anchors_[anchor] = node;
    attach(mark, std::move(node));
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, YamlNode::Kind kind) {
    count(mark);
    if (open_.size() == kMaxDepth) fail(mark, "nested more than 64 levels deep");
    auto node = std::make_shared<YamlNode>();
    node->kind = kind;
    attach(mark, node);
    open_.push_back({std::move(node), anchor, {}, {}});
  }

  void close() {
    if (open_.back().anchor != 0) anchors_[open_.back().anchor] = open_.back().node;
    open_.pop_back();
  }

  const std::string& file_;
  std::shared_ptr<const YamlNode> root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::shared_ptr<const YamlNode>> anchors_;
  int num_nodes_ = 0;
};

}  // namespace

std::shared_ptr<const YamlNode> parse_yaml(const std::string& text, const std::string& file) {
  if (text.size() > kMaxSize) throw Error(file + ": larger than 16 MiB");
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
