#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tagcal/error.hpp"

// Private to io: strict reading of YAML. Every mistake in a file throws an Error that names the
// file, the path of the key and the value.

namespace tagcal::internal {

struct YamlNode {
  enum class Kind { nothing, scalar, list, map };
  Kind kind = Kind::nothing;
  bool quoted = false;  // of a scalar: "1" is text, 1 is a number
  std::string scalar;
  std::vector<std::pair<std::string, std::shared_ptr<const YamlNode>>> children;  // "" in a list
};

// Parses one document of at most 16 MiB, 2 million values and 64 levels, without duplicate keys.
// `file` is its name in messages. Throws Error, with the line.
std::shared_ptr<const YamlNode> parse_yaml(const std::string& text, const std::string& file);

// A value in a file, and its path.
class YamlValue {
 public:
  // The top of a file, which must be a map.
  static YamlValue read(const std::filesystem::path& file);
  // The same for a text, and for a tree that was parsed; `file` is the name in messages.
  static YamlValue parse(const std::string& text, const std::string& file);
  static YamlValue of(std::shared_ptr<const YamlNode> top, const std::string& file);

  bool is_map() const { return node_->kind == YamlNode::Kind::map; }
  bool is_list() const { return node_->kind == YamlNode::Kind::list; }
  bool is_scalar() const { return node_->kind == YamlNode::Kind::scalar; }

  // Maps. Each function throws if the value is no map.
  std::optional<YamlValue> find(std::string_view key) const;
  YamlValue at(std::string_view key) const;                        // throws if the key is missing
  std::vector<std::pair<std::string, YamlValue>> members() const;  // all keys, in order
  // Returns a message for every other key; allow_only throws the first one.
  std::vector<std::string> unknown_keys(std::initializer_list<std::string_view> known) const;
  void allow_only(std::initializer_list<std::string_view> known) const;

  // Lists of `least` to `most` values.
  std::vector<YamlValue> items(std::size_t least, std::size_t most) const;
  std::vector<double> numbers(std::size_t count) const;
  std::vector<double> numbers(std::size_t least, std::size_t most) const;

  // Scalars.
  bool is_number() const;  // finite
  double number() const;
  double number_in(double low, double high) const;
  double positive() const;
  double length() const;  // > 0, in metres: a number, or with a unit (30mm)
  double not_negative() const;
  int whole(int low, int high) const;
  bool truth() const;
  std::string text() const;  // not empty

  const std::string& file() const { return *file_; }
  const std::string& path() const { return path_; }

  // Throws Error if the top of a file has the keys of another kind of file than the wanted one, of
  // those in kKinds: "a target file", "a camera's file", "a scene".
  void refuse_other_kind(std::string_view wanted) const;

  // Throws Error("file: key: must, got value").
  [[noreturn]] void fail(const std::string& must) const;
  // Throws Error("file: key: message").
  [[noreturn]] void fail_plainly(const std::string& message) const;
  // Calls a function whose errors get the file and the key before them, unless they have the file.
  template <typename F>
  auto within(const F& f) const {
    try {
      return f();
    } catch (const Error& error) {
      const std::string message = error.what();
      if (message.starts_with(file())) throw;
      fail_plainly(message);
    }
  }

 private:
  YamlValue(std::shared_ptr<const std::string> file, std::shared_ptr<const YamlNode> node,
            std::string path)
      : file_(std::move(file)), node_(std::move(node)), path_(std::move(path)) {}

  YamlValue child(std::size_t index) const;
  std::string value_shown() const;

  std::shared_ptr<const std::string> file_;
  std::shared_ptr<const YamlNode> node_;
  std::string path_;  // "boards[1].tag_size"; "" at the top
};

}  // namespace tagcal::internal
