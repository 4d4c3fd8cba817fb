#include "tagcal/io/sequence/frame_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/sequence/bag_file.hpp"

namespace tagcal::internal {
namespace {

struct BagKind {
  std::string_view ending;
  std::unique_ptr<BagFile> (*open)(const std::filesystem::path& file);
};
constexpr BagKind kBagKinds[] = {
    {".bag", open_ros1_bag}, {".mcap", open_mcap}, {".db3", open_sqlite_bag}};

std::unique_ptr<BagFile> opened_bag(const std::filesystem::path& file) {
  const auto kind = std::ranges::find(kBagKinds, ending_of(file), &BagKind::ending);
  if (kind == std::end(kBagKinds)) throw Error("is no bag (.bag, .mcap, .db3)");
  return kind->open(file);
}

// With or without a slash before it, as ROS itself takes them.
bool is_same_topic(std::string_view a, std::string_view b) {
  if (a.starts_with('/')) a.remove_prefix(1);
  if (b.starts_with('/')) b.remove_prefix(1);
  return a == b;
}

using Files = std::vector<std::unique_ptr<BagFile>>;

// "/cam0 sensor_msgs/Image (12), .."; of pictures alone, if told so.
std::string listed_topics(const Files& files) {
  constexpr std::size_t kMostListed = 20;  // topics in a message
  std::map<std::pair<std::string, std::string>, std::size_t> counts;
  for (const auto& file : files)
    for (const BagTopic& topic : file->topics())
      counts[{topic.name.substr(0, 100), topic.type.substr(0, 60)}] +=
          topic.num_messages;  // numeric: as names are
  std::string text;
  std::size_t num_listed = 0;
  for (const auto& [topic, count] : counts) {
    if (num_listed++ == kMostListed) break;
    text += fmt::format("{}{} {} ({})", text.empty() ? "" : ", ", topic.first, topic.second, count);
  }
  if (counts.empty()) return "it has no topics";
  if (counts.size() > kMostListed)
    text += fmt::format(", and {} more", counts.size() - kMostListed);
  return "it has " + text;
}

// The only topic of pictures.
std::string only_topic(const Files& files) {
  std::string only;
  for (const auto& file : files)
    for (const BagTopic& topic : file->topics()) {
      if (!is_ros_picture(topic.type) || topic.num_messages == 0 || topic.name == only) continue;
      if (!only.empty())
        throw Error("has several topics of pictures, name one (FILE:/topic): " +
                    listed_topics(files));
      only = topic.name;
    }
  if (only.empty()) throw Error("has no topic of pictures: " + listed_topics(files));
  return only;
}

void check_topic(const Files& files, const std::string& name) {
  const BagTopic* found = nullptr;
  for (const auto& file : files)
    for (const BagTopic& topic : file->topics()) {
      if (!is_same_topic(topic.name, name)) continue;
      if (is_ros_picture(topic.type) && topic.num_messages > 0) return;
      found = &topic;
    }
  if (!found) throw Error(fmt::format("has no topic {}: {}", name, listed_topics(files)));
  if (is_ros_picture(found->type))
    throw Error(fmt::format("topic {} has no messages: {}", name, listed_topics(files)));
  throw Error(fmt::format("topic {} has no pictures: {}", name, listed_topics(files)));
}

// The pictures of a topic, of one bag or of all bags in a folder, in the order of their times.
class BagSequence : public FrameSequence {
 public:
  // Throws as read_sequence.
  explicit BagSequence(const SequenceName& name);

  Image8 grey(std::size_t frame) override;
  Picture picture(std::size_t frame) override;

 private:
  struct Frame {
    std::size_t file = 0;
    BagMessage message;
  };
  void take_topic(const std::string& topic);
  void sort_by_time();
  std::string message(std::size_t frame);
  std::unique_ptr<ImageDecoder> decoder(std::size_t frame, const std::string& message) const;

  std::vector<std::unique_ptr<BagFile>> files_;
  std::vector<Frame> frames_;
  std::mutex mutex_;  // of reading files_
};

}  // namespace

BagSequence::BagSequence(const SequenceName& name) {
  const std::vector<std::filesystem::path> files = internal::files_of(name);
  if (files.empty()) throw Error("has no bags (.mcap, .db3)");
  for (const std::filesystem::path& file : files) {
    files_.push_back(opened_bag(file));
    about_.is_cut_off = about_.is_cut_off || files_.back()->is_cut_off();
  }
  if (!name.topic.empty()) check_topic(files_, name.topic);
  take_topic(name.topic.empty() ? only_topic(files_) : name.topic);
  sort_by_time();
  const std::string first = message(0);
  const ImageDecoder::Header header = decoder(0, first)->header();
  about_.size = swaps_sides(header.orientation) ? ImageSize{header.height, header.width}
                                                : ImageSize{header.width, header.height};
}

void BagSequence::take_topic(const std::string& topic) {
  for (std::size_t i = 0; i < files_.size(); ++i)
    for (const BagMessage& message : files_[i]->pictures())
      if (is_same_topic(files_[i]->topics()[message.topic].name, topic))
        frames_.push_back({i, message});
}

// By the stamps of the pictures, if all have one: a recorder may write them late.
void BagSequence::sort_by_time() {
  const bool has_stamps =
      std::ranges::all_of(frames_, [](const Frame& f) { return f.message.stamp_ns > 0; });
  const auto time_of = [&](const Frame& f) {
    return has_stamps ? f.message.stamp_ns : f.message.recorded_ns;
  };
  std::ranges::stable_sort(frames_, {}, time_of);
  constexpr double kNs = 1e-9;
  std::vector<double> seconds;
  const std::int64_t first = time_of(frames_.front());
  for (const Frame& frame : frames_)
    // Without a sign: the times of a hostile file are further apart than one holds.
    seconds.push_back(kNs * static_cast<double>(static_cast<std::uint64_t>(time_of(frame)) -
                                                static_cast<std::uint64_t>(first)));
  about_.start_s = kNs * static_cast<double>(first);
  set_times(std::move(seconds));
}

std::string BagSequence::message(std::size_t frame) {
  check_frame(frame);
  const std::lock_guard lock(mutex_);
  const Frame& place = frames_[frame];
  return files_[place.file]->read(place.message);
}

std::unique_ptr<ImageDecoder> BagSequence::decoder(std::size_t frame,
                                                   const std::string& message) const {
  const Frame& place = frames_[frame];
  const BagTopic& topic = files_[place.file]->topics()[place.message.topic];
  return ros_picture_decoder(message, topic.type, topic.coding);
}

Image8 BagSequence::grey(std::size_t frame) {
  const std::string bytes = message(frame);
  Image8 image = decode_grey8(*decoder(frame, bytes));
  check_size(frame, image.size());
  return image;
}

Picture BagSequence::picture(std::size_t frame) {
  const std::string bytes = message(frame);
  Picture picture = decode_picture(*decoder(frame, bytes));
  check_size(frame, size_of(picture));
  return picture;
}

std::shared_ptr<FrameSequence> open_bags(const SequenceName& name) {
  return std::make_shared<BagSequence>(name);
}

}  // namespace tagcal::internal
