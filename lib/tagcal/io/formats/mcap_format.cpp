#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_format.hpp"

namespace tagcal::internal {
namespace {

template <typename Number>
std::string bytes_of(Number number) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    bytes += static_cast<char>(static_cast<std::uint64_t>(number) >> 8 * i & 0xFF);
  return bytes;
}

// Bytes behind their number.
std::string sized(std::string_view bytes) {
  return bytes_of(static_cast<std::uint32_t>(bytes.size())) + std::string(bytes);
}

// A schema's name, its topic, and its fields in JSON Schema.
struct Topic {
  std::string_view name;
  std::string_view schema;
  std::string_view properties;
};

constexpr std::array<Topic, 3> kTopics = {
    {{"/camera", "foxglove.CameraCalibration",
      R"("frame_id":{"type":"string"},"width":{"type":"integer"},"height":{"type":"integer"},)"
      R"("distortion_model":{"type":"string"},"D":{"type":"array","items":{"type":"number"}},)"
      R"("K":{"type":"array","items":{"type":"number"}},)"
      R"("R":{"type":"array","items":{"type":"number"}},)"
      R"("P":{"type":"array","items":{"type":"number"}})"},
     {"/tf", "foxglove.FrameTransform",
      R"("parent_frame_id":{"type":"string"},"child_frame_id":{"type":"string"},)"
      R"("translation":{"type":"object","properties":{"x":{"type":"number"},)"
      R"("y":{"type":"number"},"z":{"type":"number"}}},)"
      R"("rotation":{"type":"object","properties":{"x":{"type":"number"},)"
      R"("y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}})"},
     {"/findings", "foxglove.Log",
      R"("level":{"type":"integer"},"message":{"type":"string"},"name":{"type":"string"},)"
      R"("file":{"type":"string"},"line":{"type":"integer"})"}}};
enum TopicNumber : std::uint16_t { kCamera = 0, kTransform = 1, kFindings = 2 };

constexpr std::string_view kTimestamp =
    R"("timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},)"
    R"("nsec":{"type":"integer"}}})";

// A file of one chunk. Checksums are 0: not stated. Messages are added in the order of time.
class McapFile {
 public:
  void add(TopicNumber topic, std::uint64_t time_ns, const std::string& json) {
    messages_[topic].emplace_back(time_ns, definitions_.size() + records_.size());
    records_ += record(kMessage, bytes_of(number_of(topic)) +
                                     bytes_of(static_cast<std::uint32_t>(sequence_++)) +
                                     bytes_of(time_ns) + bytes_of(time_ns) + json);
    if (sequence_ == 1) first_ns_ = time_ns;
    last_ns_ = time_ns;
  }

  std::string bytes() const {
    constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
    std::string file = std::string(magic) + record(kHeader, sized("") + sized("tagcal"));
    const std::size_t chunk_at = file.size();
    const std::string chunk = record(kChunk, chunk_data());
    file += chunk;
    std::string places;  // of the indices in the file, by topic
    const std::size_t indices_at = file.size();
    for (std::size_t i = 0; i < kTopics.size(); ++i) {
      if (messages_[i].empty()) continue;
      places += bytes_of(number_of(i)) + bytes_of(std::uint64_t{file.size()});
      file += index_of(i);
    }
    const std::size_t size_of_indices = file.size() - indices_at;
    file += record(kDataEnd, bytes_of(std::uint32_t{0}));
    const std::size_t summary_at = file.size();
    const std::uint64_t size = definitions_.size() + records_.size();
    file += definitions_ + statistics();
    file += record(kChunkIndex, times() + bytes_of(std::uint64_t{chunk_at}) +
                                    bytes_of(std::uint64_t{chunk.size()}) + sized(places) +
                                    bytes_of(std::uint64_t{size_of_indices}) + sized("") +
                                    bytes_of(size) + bytes_of(size));
    file += record(kFooter, bytes_of(std::uint64_t{summary_at}) + bytes_of(std::uint64_t{0}) +
                                bytes_of(std::uint32_t{0}));
    return file + std::string(magic);
  }

 private:
  enum Op : std::uint8_t {
    kHeader = 1,
    kFooter = 2,
    kSchema = 3,
    kChannel = 4,
    kMessage = 5,
    kChunk = 6,
    kMessageIndex = 7,
    kChunkIndex = 8,
    kStatistics = 11,
    kDataEnd = 15
  };

  static std::string record(Op op, const std::string& data) {
    return static_cast<char>(op) + bytes_of(std::uint64_t{data.size()}) + data;
  }

  // The number of a topic's schema and of its channel. The format keeps 0 for "no schema".
  static std::uint16_t number_of(std::size_t topic) {
    return static_cast<std::uint16_t>(topic + 1);
  }

  static std::string definitions() {
    std::string records;
    for (std::size_t i = 0; i < kTopics.size(); ++i) {
      const Topic& topic = kTopics[i];
      const std::string number = bytes_of(number_of(i));
      const std::string schema =
          fmt::format(R"({{"title":"{}","type":"object","properties":{{{},{}}}}})", topic.schema,
                      kTimestamp, topic.properties);
      records +=
          record(kSchema, number + sized(topic.schema) + sized("jsonschema") + sized(schema));
      records += record(kChannel, number + number + sized(topic.name) + sized("json") + sized(""));
    }
    return records;
  }

  std::string times() const { return bytes_of(first_ns_) + bytes_of(last_ns_); }

  std::string chunk_data() const {
    const std::string records = definitions_ + records_;
    const std::uint64_t size = records.size();
    return times() + bytes_of(size) + bytes_of(std::uint32_t{0}) + sized("") + bytes_of(size) +
           records;
  }

  // The places of a topic's messages in the chunk, by time.
  std::string index_of(std::size_t topic) const {
    std::string entries;
    for (const auto& [time_ns, at] : messages_[topic])
      entries += bytes_of(time_ns) + bytes_of(std::uint64_t{at});
    return record(kMessageIndex, bytes_of(number_of(topic)) + sized(entries));
  }

  std::string statistics() const {
    std::string counts;
    for (std::size_t i = 0; i < kTopics.size(); ++i)
      counts += bytes_of(number_of(i)) + bytes_of(std::uint64_t{messages_[i].size()});
    const std::string none = bytes_of(std::uint32_t{0});  // attachments, metadata
    return record(kStatistics, bytes_of(std::uint64_t{sequence_}) +
                                   bytes_of(std::uint16_t{kTopics.size()}) +
                                   bytes_of(std::uint32_t{kTopics.size()}) + none + none +
                                   bytes_of(std::uint32_t{1}) + times() + sized(counts));
  }

  const std::string definitions_ = definitions();  // of schemas and channels
  std::string records_;
  std::array<std::vector<std::pair<std::uint64_t, std::size_t>>, kTopics.size()> messages_;
  std::size_t sequence_ = 0;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
};

// A time as JSON and in nanoseconds. `seconds` as PoseTimes has it. Throws Error if the schemas'
// 32 bits cannot hold it.
struct Stamp {
  std::uint64_t ns = 0;
  std::string json;

  explicit Stamp(const std::string& seconds) {
    const std::size_t point = std::min(seconds.find('.'), seconds.size());
    std::string fraction = point < seconds.size() ? seconds.substr(point + 1) : "";
    fraction.resize(9, '0');
    const double whole = *parse_number("0" + seconds.substr(0, point));
    if (whole > std::numeric_limits<std::uint32_t>::max())
      throw Error(
          fmt::format("the time {} s is too late for mcap: it must be below 2^32 s", seconds));
    const auto sec = static_cast<std::uint64_t>(whole);
    const auto nsec = static_cast<std::uint64_t>(*parse_number(fraction));
    ns = sec * 1'000'000'000 + nsec;
    json = fmt::format(R"("timestamp":{{"sec":{},"nsec":{}}})", sec, nsec);
  }
};

std::string camera_json(const FileCamera& camera, const std::string& frame) {
  CameraInfo info = camera_info(camera, "mcap");
  if (info.model == "equidistant") info.model = "kannala_brandt";  // its name at Foxglove
  const ImageSize& size = camera.calibration.camera.image_size;
  return fmt::format(
      R"("frame_id":{},"width":{},"height":{},"distortion_model":"{}","D":{},"K":{},"R":{},"P":{})",
      frame, size.width, size.height, info.model, dotted_list(info.distortion),
      dotted_list(std::span(info.camera.data(), 9)),
      dotted_list(std::span(info.rectification.data(), 9)),
      dotted_list(std::span(info.projection.data(), 12)));
}

std::string transform_json(const Pose& world_from_camera, const std::string& frame) {
  const Eigen::Vector3d& t = world_from_camera.translation();
  const Eigen::Quaterniond q = world_from_camera.rotation();
  return fmt::format(
      R"("parent_frame_id":"world","child_frame_id":{},)"
      R"("translation":{{"x":{},"y":{},"z":{}}},"rotation":{{"x":{},"y":{},"z":{},"w":{}}})",
      frame, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::string log_json(const ImagePose& pose, const Finding& finding) {
  constexpr int kInfo = 2, kWarning = 3, kError = 4;  // levels of foxglove.Log
  const int level = finding.severity == Severity::note      ? kInfo
                    : finding.severity == Severity::warning ? kWarning
                                                            : kError;
  return fmt::format(R"("level":{},"message":{},"name":{},"file":"","line":0)", level,
                     json_text(pose.image + ": " + finding.sentence), json_text(finding.code));
}

}  // namespace

FormatOutput write_mcap(const CameraFile& file) {
  const FileCamera& camera = only_camera(file, "mcap");
  const std::string frame = json_text(camera.name.empty() ? "camera" : camera.name);
  const std::string calibration = camera_json(camera, frame);
  FormatOutput output;
  McapFile mcap;
  const auto add = [&](TopicNumber topic, const Stamp& stamp, const std::string& fields) {
    mcap.add(topic, stamp.ns, "{" + stamp.json + "," + fields + "}");
  };
  const PoseTimes times = times_of(file.poses);
  std::vector<std::pair<Stamp, const ImagePose*>> poses;
  for (std::size_t i = 0; i < file.poses.size(); ++i)
    poses.emplace_back(Stamp(times.seconds[i]), &file.poses[i]);
  std::ranges::stable_sort(poses, {}, [](const auto& p) { return p.first.ns; });
  if (poses.empty()) add(kCamera, Stamp("0"), calibration);
  for (const auto& [stamp, of_picture] : poses) {
    const ImagePose& pose = *of_picture;
    add(kCamera, stamp, calibration);
    add(kTransform, stamp, transform_json(pose.camera_from_world.inverse(), frame));
    for (const Finding& finding : pose.findings) add(kFindings, stamp, log_json(pose, finding));
  }
  output.files = {{"", mcap.bytes()}};
  if (!poses.empty()) output.notes.push_back(times.note);
  note_no_uncertainty(file, output.notes);
  note_no_rig(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
