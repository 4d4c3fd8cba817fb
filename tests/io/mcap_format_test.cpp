// MCAP as https://mcap.dev/spec has it, read record by record.

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal {
namespace {

using Json = nlohmann::json;

// Little-endian values one after the other; fails at the end.
struct Reader {
  std::string bytes;
  std::size_t at = 0;

  std::string take(std::size_t count) {
    EXPECT_LE(at + count, bytes.size());
    at += count;
    return bytes.substr(std::min(at - count, bytes.size()), count);
  }
  template <int kBytes>
  std::uint64_t number() {
    std::uint64_t value = 0;
    const std::string text = take(kBytes);
    for (int i = kBytes - 1; i >= 0; --i)
      value = value << 8 | static_cast<std::uint8_t>(text[static_cast<std::size_t>(i)]);
    return value;
  }
  std::string text() { return take(number<4>()); }
  bool at_end() const { return at >= bytes.size(); }
};

struct Record {
  int op;
  std::size_t at;  // of its first byte
  Reader data;
};

std::vector<Record> records_of(const std::string& bytes, std::size_t begin, std::size_t end) {
  std::vector<Record> records;
  Reader reader{bytes.substr(0, end), begin};
  while (!reader.at_end()) {
    const std::size_t at = reader.at;
    const int op = static_cast<int>(reader.number<1>());
    records.push_back({op, at, {reader.take(reader.number<8>())}});
  }
  return records;
}

struct Message {
  std::string topic;
  std::uint64_t ns = 0;
  Json json;
};

const std::string kMagic = std::string("\x89MCAP0\r\n", 8);

class McapFormat : public FileTest {
 protected:
  McapFormat() {
    FileCamera camera{
        "left", {{Perspective({500, 501, 320, 240, -0.1, 0.02}), {640, 480}}, "", {}, {}, {}, {}}};
    file_.cameras = {camera};
    for (int i = 0; i < 3; ++i)
      file_.poses.push_back({"a" + std::to_string(i), 0,
                             Pose(Eigen::Quaterniond(0.8, 0, 0.6, 0), {0.1 * i, 0, 1}), 12.5 - i});
    file_.poses[1].findings = {{"noise_assumed", Severity::warning, "says \"so\""}};
  }

  // Writes the file, and reads it by its index.
  std::vector<Message> written() {
    const fs::path out = folder_ / "p.mcap";
    notes_ = write_camera_file(out, file_, "mcap");
    const std::string bytes = read_text(out);
    EXPECT_TRUE(bytes.starts_with(kMagic) && bytes.ends_with(kMagic));
    std::vector<Record> all = records_of(bytes, 8, bytes.size() - 8);
    EXPECT_EQ(all.front().op, 1);
    EXPECT_EQ(all.back().op, 2);
    const std::size_t summary = all.back().data.number<8>();
    std::map<std::uint64_t, std::string> schemas, topics;
    std::uint64_t num_messages = 0;
    std::vector<Message> messages;
    for (Record& record : records_of(bytes, summary, all.back().at)) {
      Reader& data = record.data;
      if (record.op == 3) {
        const auto id = data.number<2>();
        schemas[id] = data.text();
        EXPECT_EQ(data.text(), "jsonschema");
        EXPECT_EQ(Json::parse(data.text())["title"], schemas[id]);
      } else if (record.op == 4) {
        const auto id = data.number<2>();
        const std::string schema = schemas.at(data.number<2>());
        topics[id] = data.text() + " " + schema;
        EXPECT_EQ(data.text(), "json");
      } else if (record.op == 11) {
        num_messages = data.number<8>();
        EXPECT_EQ(data.number<2>(), 3U);
        EXPECT_EQ(data.number<4>(), 3U);
      } else {
        EXPECT_EQ(record.op, 8);
        messages = by_index(bytes, data, topics);
      }
    }
    EXPECT_EQ(messages.size(), num_messages);
    std::ranges::stable_sort(messages, {}, &Message::ns);
    return messages;
  }

  CameraFile file_;
  std::vector<std::string> notes_;

 private:
  static std::vector<Message> by_index(const std::string& bytes, Reader& index,
                                       std::map<std::uint64_t, std::string>& topics) {
    const auto first = index.number<8>(), last = index.number<8>();
    const std::size_t chunk_at = index.number<8>(), chunk_size = index.number<8>();
    Reader chunk{records_of(bytes, chunk_at, chunk_at + chunk_size).at(0).data};
    EXPECT_EQ(chunk.number<8>(), first);
    EXPECT_EQ(chunk.number<8>(), last);
    const auto size = chunk.number<8>();
    chunk.number<4>();
    EXPECT_EQ(chunk.text(), "");
    EXPECT_EQ(chunk.number<8>(), size);
    const std::string records = chunk.take(size);
    EXPECT_TRUE(chunk.at_end());
    std::vector<Message> messages;
    Reader places{index.text()};
    while (!places.at_end()) {
      const auto topic = places.number<2>();
      const std::size_t at = places.number<8>();
      Record entry = records_of(bytes, at, bytes.size() - 8).at(0);
      EXPECT_EQ(entry.op, 7);
      EXPECT_EQ(entry.data.number<2>(), topic);
      Reader entries{entry.data.text()};
      while (!entries.at_end()) {
        const auto ns = entries.number<8>();
        const std::size_t place = entries.number<8>();
        Record message = records_of(records, place, records.size()).at(0);
        EXPECT_EQ(message.op, 5);
        EXPECT_EQ(message.data.number<2>(), topic);
        message.data.number<4>();
        EXPECT_EQ(message.data.number<8>(), ns);
        EXPECT_EQ(message.data.number<8>(), ns);
        EXPECT_TRUE(first <= ns && ns <= last);
        const std::string json = message.data.bytes.substr(message.data.at);
        messages.push_back({topics.at(topic), ns, Json::parse(json)});
      }
    }
    return messages;
  }
};

TEST_F(McapFormat, HasCameraPlaceAndFindingsAtEachTime) {
  const std::vector<Message> messages = written();
  ASSERT_EQ(messages.size(), 7U);
  EXPECT_EQ(messages[0].ns, 10'500'000'000U);  // the last pose is the first in time
  const Json camera = {{"timestamp", {{"sec", 10}, {"nsec", 500'000'000}}},
                       {"frame_id", "left"},
                       {"width", 640},
                       {"height", 480},
                       {"distortion_model", "plumb_bob"},
                       {"D", {-0.1, 0.02, 0.0, 0.0, 0.0}},
                       {"K", {500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0}},
                       {"R", {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}},
                       {"P", {500.0, 0.0, 320.0, 0.0, 0.0, 501.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0}}};
  EXPECT_EQ(messages[0].topic, "/camera foxglove.CameraCalibration");
  EXPECT_EQ(messages[0].json, camera);
  EXPECT_EQ(messages[1].topic, "/tf foxglove.FrameTransform");
  const Json& place = messages[1].json;
  EXPECT_EQ(place["parent_frame_id"], "world");
  EXPECT_EQ(place["child_frame_id"], "left");
  const Pose expected = file_.poses[2].camera_from_world.inverse();
  const Json &t = place["translation"], &q = place["rotation"];
  const auto number = [](const Json& value) { return value.get<double>(); };
  const Pose world_from_camera(
      Eigen::Quaterniond(number(q["w"]), number(q["x"]), number(q["y"]), number(q["z"])),
      {number(t["x"]), number(t["y"]), number(t["z"])});
  EXPECT_LT(minus(world_from_camera, expected).norm(), 1e-15);
  const auto log =
      std::ranges::find(messages, std::string("/findings foxglove.Log"), &Message::topic);
  ASSERT_NE(log, messages.end());
  EXPECT_EQ(log->ns, 11'500'000'000U);
  EXPECT_EQ(log->json["level"], 3);
  EXPECT_EQ(log->json["message"], "a1: says \"so\"");
  EXPECT_EQ(log->json["name"], "noise_assumed");
  EXPECT_EQ(notes_, std::vector<std::string>{"timestamps are the times of the pictures"});
}

TEST_F(McapFormat, NamesAFisheyeAsItsReadersDo) {
  file_.cameras[0].calibration.camera.lens = Fisheye({500, 500, 320, 240, 0.1, 0.2, 0.3, 0.4});
  file_.poses.clear();
  const std::vector<Message> messages = written();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].json["distortion_model"], "kannala_brandt");
  EXPECT_EQ(messages[0].json["D"], (Json{0.1, 0.2, 0.3, 0.4}));
}

TEST_F(McapFormat, RefusesWhatItCannotHold) {
  file_.poses[0].time_s.reset();
  file_.poses[0].image = "1403636579763.png";  // milliseconds
  file_.poses[1].image = "1.png";
  file_.poses[2].image = "2.png";
  const auto error = [&] { return error_of([&] { written(); }); };
  EXPECT_HAS(error(), "1403636579763 s is too late");
  file_.cameras[0].calibration.camera.lens = DoubleSphere({500, 500, 320, 240, -0.2, 0.6});
  EXPECT_HAS(error(), "mcap has no double sphere lens");
  file_.cameras.push_back(file_.cameras[0]);
  EXPECT_HAS(error(), "holds one camera");
  EXPECT_FALSE(fs::exists(folder_ / "p.mcap"));
}

}  // namespace
}  // namespace tagcal
