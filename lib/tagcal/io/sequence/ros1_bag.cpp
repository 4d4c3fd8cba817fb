// Bags of ROS 1, version 2.0: http://wiki.ros.org/Bags/Format/2.0
#include <map>
#include <optional>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/bag_file.hpp"

namespace tagcal::internal {
namespace {

constexpr std::string_view kRos1Magic = "#ROSBAG V2.0\n";

using Fields = std::map<std::string, std::string, std::less<>>;

// "name=value" with a length before each.
Fields fields_of(std::string_view header) {
  Fields fields;
  for (ByteReader reader(header); !reader.at_end();) {
    const std::string_view field = reader.text();
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw Damage();
    fields.emplace(field.substr(0, equals), field.substr(equals + 1));
  }
  return fields;
}

const std::string& field(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end()) throw Damage();
  return found->second;
}

template <typename Number>
Number number(const Fields& fields, std::string_view name) {
  return ByteReader(field(fields, name)).next<Number>();
}

class Ros1Bag : public RecordBag {
 public:
  explicit Ros1Bag(const std::filesystem::path& file) : RecordBag(file) {
    const BagBytes all = bytes();
    if (!all.holds(0, kRos1Magic.size()) || all.part(0, kRos1Magic.size()) != kRos1Magic)
      throw Error("is no bag of ROS 1, version 2.0");
    walk_file(kRos1Magic.size());
  }

 private:
  enum Op : std::uint8_t { kMessage = 2, kChunk = 5, kConnection = 7 };

  void walk(const BagBytes& bytes, int chunk, bool is_chunk) override {
    constexpr std::uint32_t kMaxHeader = 1U << 20;  // numeric: a definition of messages is data
    for (std::uint64_t at = 0; at < bytes.size();) {
      const auto length = bytes.number<std::uint32_t>(at);
      if (length > kMaxHeader) throw Damage();
      const Fields fields = fields_of(bytes.part(at + 4, length));
      const auto size = bytes.number<std::uint32_t>(at + 4 + length);
      const std::uint64_t data = at + 8 + length;
      const auto op = number<std::uint8_t>(fields, "op");
      if (op == kChunk && !is_chunk) take_chunk(fields, bytes, data, size);
      if (!bytes.holds(data, size)) throw Damage();
      if (op == kConnection) take_connection(fields, bytes.part(data, size));
      if (op == kMessage) take_message(fields, bytes, {.chunk = chunk, .at = data, .size = size});
      at = data + size;
    }
  }

  // An uncompressed one may have been cut off.
  void take_chunk(const Fields& fields, const BagBytes& bytes, std::uint64_t at,
                  std::uint32_t stored) {
    walk_chunk({field(fields, "compression"), bytes.begin() + at, stored,
                number<std::uint32_t>(fields, "size")});
  }

  void take_connection(const Fields& fields, const std::string& data) {
    const Fields about = fields_of(data);
    connections_[number<std::uint32_t>(fields, "conn")] =
        add_topic(field(fields, "topic"), field(about, "type"), RosCoding::ros1);
  }

  void take_message(const Fields& fields, const BagBytes& bytes, BagMessage message) {
    const auto connection = connections_.find(number<std::uint32_t>(fields, "conn"));
    if (connection == connections_.end()) throw Damage();
    ByteReader time(field(fields, "time"));
    const auto seconds = time.next<std::uint32_t>();
    message.recorded_ns = ns_of(seconds, time.next<std::uint32_t>());
    message.topic = connection->second;
    const std::string begin =
        bytes.part(message.at, std::min<std::uint64_t>(message.size, kStampBytes));
    message.at += bytes.begin();
    add_message(message, begin);
  }

  std::map<std::uint32_t, std::size_t> connections_;  // their topics
};

}  // namespace

std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& file) {
  return std::make_unique<Ros1Bag>(file);
}

}  // namespace tagcal::internal
