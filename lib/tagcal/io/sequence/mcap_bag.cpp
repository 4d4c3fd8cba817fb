// MCAP with messages of ROS 1 or 2: https://mcap.dev/spec
#include <algorithm>
#include <map>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/bag_file.hpp"

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n"sv;

class McapBag : public RecordBag {
 public:
  explicit McapBag(const std::filesystem::path& file) : RecordBag(file) {
    const BagBytes all = bytes();
    if (!all.holds(0, kMcapMagic.size()) || all.part(0, kMcapMagic.size()) != kMcapMagic)
      throw Error("is no MCAP file");
    walk_file(kMcapMagic.size());
  }

 private:
  enum Op : std::uint8_t { kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6 };

  void walk(const BagBytes& bytes, int chunk, bool is_chunk) override {
    for (std::uint64_t at = 0; at < bytes.size() || !is_chunk;) {
      const auto op = bytes.number<std::uint8_t>(at);
      const auto size = bytes.number<std::uint64_t>(at + 1);
      const std::uint64_t data = at + 9;
      if (op == kFooter && !is_chunk) return;
      if (op == kChunk && !is_chunk) take_chunk(bytes, data);
      if (!bytes.holds(data, size)) throw Damage();
      if (op == kSchema) take_schema(bytes.part(data, size));
      if (op == kChannel) take_channel(bytes.part(data, size));
      if (op == kMessage) take_message(bytes, chunk, data, size);
      at = data + size;
    }
  }

  void take_chunk(const BagBytes& bytes, std::uint64_t at) {
    constexpr std::uint64_t kBefore = 28;  // numeric: two times, the size, its checksum
    const auto size = bytes.number<std::uint64_t>(at + 16);
    const auto length = bytes.number<std::uint32_t>(at + kBefore);
    const std::uint64_t records = at + kBefore + 4 + length;
    if (length > 64) throw Damage();  // numeric: no name of a compression is as long
    walk_chunk({bytes.part(at + kBefore + 4, length), bytes.begin() + records + 8,
                bytes.number<std::uint64_t>(records), size});
  }

  void take_schema(const std::string& data) {
    ByteReader reader(data);
    const auto id = reader.next<std::uint16_t>();
    types_[id] = reader.text();
  }

  void take_channel(const std::string& data) {
    ByteReader reader(data);
    const auto id = reader.next<std::uint16_t>();
    const auto type = types_.find(reader.next<std::uint16_t>());
    const std::string name(reader.text());
    const std::string_view coding = reader.text();
    // Other codings are those of other systems: their topics are listed, and hold no pictures.
    const bool is_known = (coding == "cdr" || coding == "ros1") && type != types_.end();
    const std::string what = type == types_.end() ? "?" : type->second;
    channels_[id] = add_topic(name, is_known ? what : what + " in " + std::string(coding),
                              coding == "cdr" ? RosCoding::cdr : RosCoding::ros1);
  }

  void take_message(const BagBytes& bytes, int chunk, std::uint64_t at, std::uint64_t size) {
    constexpr std::uint64_t kBefore = 22;  // numeric: channel, number, two times
    if (size < kBefore) throw Damage();
    const std::string head = bytes.part(at, std::min(size, kBefore + kStampBytes));
    ByteReader reader(head);
    const auto channel = channels_.find(reader.next<std::uint16_t>());
    if (channel == channels_.end()) throw Damage();
    reader.next<std::uint32_t>();
    BagMessage message{.topic = channel->second};
    message.recorded_ns = reader.next<std::int64_t>();
    message.chunk = chunk;
    message.at = bytes.begin() + at + kBefore;
    message.size = size - kBefore;
    add_message(message, std::string_view(head).substr(kBefore));
  }

  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, std::size_t> channels_;  // their topics
};

}  // namespace

std::unique_ptr<BagFile> open_mcap(const std::filesystem::path& file) {
  return std::make_unique<McapBag>(file);
}

}  // namespace tagcal::internal
