#include "tagcal/io/sequence/bag_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/bag_bytes.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {

std::size_t BagFile::add_topic(const std::string& name, std::string type, RosCoding coding) {
  if (const std::size_t part = type.find("/msg/"); part != std::string::npos) type.erase(part, 4);
  const auto equal = std::ranges::find_if(
      topics_, [&](const BagTopic& t) { return t.name == name && t.type == type; });
  if (equal != topics_.end()) return static_cast<std::size_t>(equal - topics_.begin());
  if (topics_.size() == limits::kMaxBagTopics)
    throw Error(fmt::format("has more than {} topics", limits::kMaxBagTopics));
  topics_.push_back({name, std::move(type), coding, 0});
  return topics_.size() - 1;
}

void BagFile::add_message(BagMessage message, std::string_view begin) {
  BagTopic& topic = topics_[message.topic];
  ++topic.num_messages;
  if (!is_ros_picture(topic.type)) return;
  if (pictures_.size() == limits::kMaxSequenceFrames)
    throw Error(fmt::format("has more than {} pictures", limits::kMaxSequenceFrames));
  message.stamp_ns = ros_stamp_ns(begin, topic.coding);
  pictures_.push_back(message);
}

void BagFile::allow_unpacking(std::uint64_t size, std::uint64_t file_size) {
  if (size > limits::kMaxBagChunkBytes)
    throw Error(
        fmt::format("has a chunk of {} bytes, more than {}", size, limits::kMaxBagChunkBytes));
  num_unpacked_ += size;
  if (num_unpacked_ >
      std::max(limits::kMaxBagBytesOfFewBytes, limits::kMaxBagBytesAByte * file_size))
    throw Error(fmt::format("has chunks that unpack to more than {} times its length",
                            limits::kMaxBagBytesAByte));
}

void RecordBag::walk_file(std::uint64_t start) {
  const BagBytes all = bytes();
  try {
    walk(all.clipped(start, all.size()), -1, false);
  } catch (const Damage&) {
    is_cut_off_ = true;
  }
}

void RecordBag::walk_chunk(const Chunk& chunk) {
  if (chunk.kind.empty() || chunk.kind == "none") {
    walk(bytes().clipped(chunk.at, chunk.stored), -1, true);
    return;
  }
  allow_unpacking(chunk.size, bytes().size());
  const std::string all = unpacked(chunk);
  chunks_.push_back(chunk);
  walk(BagBytes(all), static_cast<int>(chunks_.size()) - 1, true);
}

std::string RecordBag::unpacked(const Chunk& chunk) const {
  return decompressed(chunk.kind, bytes().part(chunk.at, chunk.stored), chunk.size);
}

std::string RecordBag::read(const BagMessage& message) {
  try {
    if (message.chunk < 0) return bytes().part(message.at, message.size);
    if (message.chunk != last_) {
      last_bytes_ = unpacked(chunks_[static_cast<std::size_t>(message.chunk)]);
      last_ = message.chunk;
    }
    return BagBytes(last_bytes_).part(message.at, message.size);
  } catch (const Damage&) {
    throw Error("has changed while it was read");
  }
}

}  // namespace tagcal::internal
