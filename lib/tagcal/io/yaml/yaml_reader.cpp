#include "tagcal/io/yaml/yaml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

// Levenshtein's distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0U : 1U)});
      diagonal = above;
    }
  }
  return row.back();
}

// A key that files of one kind have at their top, and files of no other kind.
struct KindOfFile {
  std::string_view key, name;
};
constexpr KindOfFile kKinds[] = {
    {"target_type", "a target file"},
    {"camera_matrix", "a camera's file"},
    {"cam0", "a camera's file"},
    {"cameras", "a rig's file"},
    {"images", "a data set"},
    {"poses", "the truth of a data set"},
    {"path", "a scene"},
};

std::string without_underscores(std::string_view key) {
  std::string letters = lower_case(key);
  std::erase(letters, '_');
  return letters;
}

// A key that may stand for a missing one: "cols" or "tag_cols" for "tagCols". Empty if there is
// none.
std::string_view key_instead(const YamlNode& map, std::string_view missing) {
  constexpr std::size_t kShortest = 3;  // numeric: letters; less are part of many words
  const std::string wanted = without_underscores(missing);
  for (const auto& [key, node] : map.children) {
    const std::string letters = without_underscores(key);
    if (letters.size() >= kShortest && wanted.find(letters) != std::string::npos) return key;
  }
  return {};
}

// Suggests a known key, or lists all of them.
std::string advice(std::string_view key, std::initializer_list<std::string_view> known) {
  std::string_view nearest;
  std::size_t least = std::max<std::size_t>(2, key.size() / 3) + 1;
  std::string all;
  for (const std::string_view candidate : known) {
    all += (all.empty() ? "" : ", ") + std::string(candidate);
    if (key.size() > 60) continue;
    const std::size_t distance = edit_distance(lower_case(key), lower_case(candidate));
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest.empty() ? "known keys are " + all : fmt::format("did you mean {}?", nearest);
}

}  // namespace

YamlValue YamlValue::read(const std::filesystem::path& file) {
  return parse(read_text(file), file.string());
}

YamlValue YamlValue::parse(const std::string& text, const std::string& file) {
  return of(parse_yaml(text, file), file);
}

YamlValue YamlValue::of(std::shared_ptr<const YamlNode> top, const std::string& file) {
  YamlValue value(std::make_shared<const std::string>(file), std::move(top), "");
  if (value.is_scalar() && value.node_->scalar.starts_with("image,"))
    value.fail_plainly("is a table (CSV), not YAML");
  if (!value.is_map()) value.fail("must be a map of keys");
  return value;
}

void YamlValue::refuse_other_kind(std::string_view wanted) const {
  if (!path_.empty()) return;
  for (const KindOfFile& kind : kKinds)
    if (kind.name != wanted && find(kind.key))
      fail_plainly(fmt::format("is {}, not {}", kind.name, wanted));
}

std::string YamlValue::value_shown() const {
  switch (node_->kind) {
    case YamlNode::Kind::nothing:
      return "nothing";
    case YamlNode::Kind::scalar:
      return node_->quoted ? '"' + shown(node_->scalar) + '"' : shown(node_->scalar);
    case YamlNode::Kind::list:
      return fmt::format("a list of {}", node_->children.size());
    case YamlNode::Kind::map:
      return "a map";
  }
  return "";
}

void YamlValue::fail(const std::string& must) const {
  fail_plainly(must + ", got " + value_shown());
}

void YamlValue::fail_plainly(const std::string& message) const {
  throw Error(*file_ + ": " + (path_.empty() ? "" : path_ + ": ") + message);
}

YamlValue YamlValue::child(std::size_t index) const {
  const auto& [key, node] = node_->children[index];
  const std::string path = is_list() ? fmt::format("{}[{}]", path_, index)
                                     : path_ + (path_.empty() ? "" : ".") + shown(key);
  return {file_, node, path};
}

std::optional<YamlValue> YamlValue::find(std::string_view key) const {
  if (!is_map()) fail("must be a map of keys");
  for (std::size_t i = 0; i < node_->children.size(); ++i) {
    if (node_->children[i].first == key) return child(i);
  }
  return std::nullopt;
}

YamlValue YamlValue::at(std::string_view key) const {
  if (auto value = find(key)) return *value;
  const std::string_view other = key_instead(*node_, key);
  throw Error(fmt::format(
      "{}: {}{}{}: the key is missing{}", *file_, path_, path_.empty() ? "" : ".", key,
      other.empty() ? "" : fmt::format("; if {} is meant, write {}", shown(other), key)));
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::members() const {
  if (!is_map()) fail("must be a map of keys");
  std::vector<std::pair<std::string, YamlValue>> members;
  for (std::size_t i = 0; i < node_->children.size(); ++i)
    members.emplace_back(node_->children[i].first, child(i));
  return members;
}

std::vector<std::string> YamlValue::unknown_keys(
    std::initializer_list<std::string_view> known) const {
  if (!is_map()) fail("must be a map of keys");
  constexpr std::size_t kMost = 20;  // a file may have millions
  const std::string where = path_.empty() ? "" : path_ + ": ";
  std::vector<std::string> messages;
  for (std::size_t i = 0; i < node_->children.size(); ++i) {
    const std::string& key = node_->children[i].first;
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    if (messages.size() == kMost) {
      messages.push_back(fmt::format("{}: {}has more unknown keys", *file_, where));
      break;
    }
    messages.push_back(
        fmt::format("{}: {}: unknown key; {}", *file_, child(i).path_, advice(key, known)));
  }
  return messages;
}

void YamlValue::allow_only(std::initializer_list<std::string_view> known) const {
  const std::vector<std::string> messages = unknown_keys(known);
  if (!messages.empty()) throw Error(messages.front());
}

std::vector<YamlValue> YamlValue::items(std::size_t least, std::size_t most) const {
  const std::size_t size = node_->children.size();
  if (!is_list() || size < least || size > most) {
    const std::string count = least == most ? fmt::format("{}", least)
                              : size > most ? fmt::format("at most {}", most)
                                            : fmt::format("at least {}", least);
    fail(is_list() ? "must be a list of " + count : "must be a list");
  }
  std::vector<YamlValue> values;
  for (std::size_t i = 0; i < size; ++i) values.push_back(child(i));
  return values;
}

std::vector<double> YamlValue::numbers(std::size_t count) const { return numbers(count, count); }

std::vector<double> YamlValue::numbers(std::size_t least, std::size_t most) const {
  std::vector<double> values;
  for (const YamlValue& item : items(least, most)) values.push_back(item.number());
  return values;
}

bool YamlValue::is_number() const {
  return is_scalar() && !node_->quoted && parse_number(node_->scalar);
}

double YamlValue::number() const {
  if (!is_number()) fail("must be a finite number");
  return *parse_number(node_->scalar);
}

double YamlValue::number_in(double low, double high) const {
  const double value = number();
  if (value < low || value > high) fail(fmt::format("must be from {} to {}", low, high));
  return value;
}

double YamlValue::positive() const {
  const double value = number();
  if (!(value > 0)) fail("must be > 0");
  return value;
}

double YamlValue::length() const {
  if (is_number()) return positive();
  const auto metres = is_scalar() ? parse_length(node_->scalar) : std::nullopt;
  if (!metres) fail("must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in)");
  if (!(*metres > 0)) fail("must be > 0");
  return *metres;
}

double YamlValue::not_negative() const {
  const double value = number();
  if (!(value >= 0)) fail("must be >= 0");
  return value;
}

int YamlValue::whole(int low, int high) const {
  std::optional<int> value;
  if (is_scalar() && !node_->quoted) value = parse_whole(node_->scalar);
  if (!value || *value < low || *value > high) {
    fail(fmt::format("must be a whole number from {} to {}", low, high));
  }
  return *value;
}

bool YamlValue::truth() const {
  const std::string value = is_scalar() && !node_->quoted ? lower_case(node_->scalar) : "";
  if (value == "true" || value == "yes") return true;
  if (value == "false" || value == "no") return false;
  fail("must be true or false");
}

std::string YamlValue::text() const {
  if (!is_scalar() || node_->scalar.empty()) fail("must be a text");
  return node_->scalar;
}

}  // namespace tagcal::internal
