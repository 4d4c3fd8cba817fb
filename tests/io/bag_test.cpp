// Bags that the libraries of ROS, @mcap/core and SQLite wrote (tests/data/bags) are read back:
// pixels, order, times; and what is cut off, damaged or made to take the memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>

#include "file_fixture.hpp"
#include "mcap_writer.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal {
namespace {

namespace limits = internal::limits;

const fs::path kBags = fs::path(TAGCAL_SOURCE_DIR) / "tests/data/bags";
const char* const kNames[] = {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag",
                              "plain.mcap",    "chunks.mcap",  "lz4.mcap",
                              "zstd.mcap",     "plain.db3",    "packed.db3"};
constexpr int kWidth = 24, kHeight = 16;

int pattern(int x, int y, int frame, int plus = 0) {
  return (7 * x + 13 * y + 40 * frame + plus) % 256;
}

// Pixels of frame i that differ from the pattern.
int num_wrong(const fs::path& topic, int i) {
  const Image8 grey = read_image(frame_path(topic, i));
  if (grey.size() != ImageSize{kWidth, kHeight}) return -1;
  int wrong = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) wrong += grey(x, y) != pattern(x, y, i);
  return wrong;
}

class Bag : public FileTest {
 protected:
  std::string error(const fs::path& sequence) {
    return error_of([&] { read_sequence(sequence); });
  }
};

TEST_F(Bag, PixelsAreThoseThatWereWritten) {
  for (const std::string name : kNames)
    for (int i = 0; i < 3; ++i) {
      const auto topic = [&](const char* t) { return fs::path((kBags / name).string() + ":" + t); };
      EXPECT_EQ(num_wrong(topic("/mono8"), i), 0) << name;
      EXPECT_EQ(num_wrong(topic("/packed"), i), 0) << name;
      for (const char* colour : {"/rgb8", "/bgr8"}) {
        const auto image = std::get<ImageRgb>(read_picture(frame_path(topic(colour), i)));
        ASSERT_EQ(image.size(), (ImageSize{kWidth, kHeight}));
        for (int y = 0; y < kHeight; ++y)
          for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c)
              ASSERT_EQ(image(x, y)[c], pattern(x, y, i, 50 * c)) << name << colour;
      }
      const auto deep = std::get<Image16>(read_picture(frame_path(topic("/mono16"), i)));
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_EQ(deep(x, y), 256 * pattern(x, y, i)) << name;
      const auto mosaic = std::get<ImageRgb>(read_picture(frame_path(topic("/bayer"), i)));
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_EQ(mosaic(x, y), (Rgb{200, 100, 50})) << name;
    }
}

TEST_F(Bag, FramesAreInTheOrderOfTheirStamps) {
  for (const std::string name : kNames) {
    const ImageSequence about = read_sequence((kBags / name).string() + ":/mono8");
    EXPECT_EQ(about.size, (ImageSize{kWidth, kHeight}));
    ASSERT_EQ(about.times_s.size(), 3U) << name;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(about.times_s[i], 0.1 * i, 1e-9) << name;
    EXPECT_NEAR(about.start_s, 1.7e9, 1e-6);
    EXPECT_FALSE(about.is_cut_off) << name;
    EXPECT_FALSE(about.is_uneven);
  }
}

TEST_F(Bag, AFolderIsAllItsBags) {
  fs::copy(kBags / "plain.db3", folder_ / "part_0.db3");
  fs::copy(kBags / "lz4.mcap", folder_ / "part_1.mcap");
  const fs::path topic = folder_.string() + ":/mono8";
  EXPECT_EQ(read_sequence(topic).times_s.size(), 6U);
  EXPECT_EQ(read_image(frame_path(topic, 2))(3, 4), pattern(3, 4, 1));
  EXPECT_EQ(read_image(frame_path(topic, 5))(3, 4), pattern(3, 4, 2));
}

TEST_F(Bag, TopicsAreListedWhereOneIsMissing) {
  for (const std::string name : kNames) {
    const std::string bag = (kBags / name).string();
    const std::string none = error(bag + ":/left");
    EXPECT_EQ(none.find(bag + ":/left: has no topic /left: it has /bayer sensor_msgs/Image (3), "),
              0U)
        << none;
    EXPECT_HAS(none, "/chatter std_msgs/String (3)");
    EXPECT_HAS(error(bag), "has several topics of pictures");
    EXPECT_HAS(error(bag + ":/chatter"), "topic /chatter has no pictures");
  }
  McapWriter one("/camera");
  one.add(McapWriter::message(Image8({8, 6}), 3));
  EXPECT_EQ(read_sequence(write("one.mcap", one.bytes())).times_s.size(), 1U);
  EXPECT_HAS(error(write("none.mcap", McapWriter("/camera").bytes())), "(0)");
}

TEST_F(Bag, BothOrdersOfBytesAreRead) {
  Image8 image({5, 3});
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x) image(x, y) = static_cast<std::uint8_t>(10 * y + x);
  McapWriter writer("/camera");
  writer.add(McapWriter::message(image, 12.25, false));
  writer.add(McapWriter::message(image, 12.5, true));
  const fs::path file = write("both.mcap", writer.bytes());
  const ImageSequence about = read_sequence(file);
  ASSERT_EQ(about.times_s.size(), 2U);
  EXPECT_NEAR(about.times_s[1], 0.25, 1e-9);
  for (int i = 0; i < 2; ++i) {
    const Image8 read = read_image(frame_path(file, i));
    for (int y = 0; y < 3; ++y) EXPECT_TRUE(std::equal(read.row(y), read.row(y) + 5, image.row(y)));
  }
}

TEST_F(Bag, OneThatIsCutOffHasTheFramesUntilThere) {
  for (const std::string name : {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag", "plain.mcap",
                                 "chunks.mcap", "lz4.mcap", "zstd.mcap"}) {
    const std::string whole = read_text(kBags / name);
    std::size_t before = 0;
    for (std::size_t size = 0; size < whole.size(); size += 1024) {
      const fs::path file = write(std::to_string(size) + name, whole.substr(0, size));
      std::size_t count = 0;
      try {
        const ImageSequence about = read_sequence(file.string() + ":/mono8");
        count = about.times_s.size();
        EXPECT_TRUE(about.is_cut_off) << name << size;
        for (std::size_t i = 0; i < count; ++i)
          read_image(frame_path(file.string() + ":/mono8", i));
      } catch (const Error&) {
      }
      EXPECT_GE(count, before) << name << size;
      before = count;
    }
    EXPECT_EQ(before, 3U) << name;
  }
}

TEST_F(Bag, DamageThrowsOrGivesFrames) {
  std::minstd_rand random(7);
  for (const std::string name : kNames) {
    const std::string whole = read_text(kBags / name);
    for (int i = 0; i < 150; ++i) {
      std::string damaged = whole;
      if (i % 3 == 0) damaged.resize(random() % damaged.size());
      for (int k = 0; k < 5 && !damaged.empty(); ++k)
        damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
      const fs::path topic = write(std::to_string(i) + name, damaged).string() + ":/bgr8";
      try {
        const std::size_t count = read_sequence(topic).times_s.size();
        for (std::size_t k = 0; k < count; ++k) read_picture(frame_path(topic, k));
      } catch (const Error&) {
      }
    }
  }
}

// No index is followed: one that leads in circles changes nothing.
TEST_F(Bag, IndicesDecideNothing) {
  std::string bag = read_text(kBags / "ros1_none.bag");
  const std::size_t index = bag.find("index_pos=");
  ASSERT_NE(index, std::string::npos);
  bag.replace(index + 10, 8, std::string("\x0d\0\0\0\0\0\0\0", 8));
  EXPECT_EQ(num_wrong(write("circle.bag", bag).string() + ":/mono8", 2), 0);
  std::string mcap = read_text(kBags / "chunks.mcap");
  mcap.replace(mcap.size() - 28, 16, std::string("\x08\0\0\0\0\0\0\0\x08\0\0\0\0\0\0\0", 16));
  EXPECT_EQ(num_wrong(write("circle.mcap", mcap).string() + ":/mono8", 2), 0);
}

TEST_F(Bag, SizesBeyondTheLimitsAreRefused) {
  // A chunk that says that it unpacks to 2^31 bytes.
  std::string bag = read_text(kBags / "ros1_lz4.bag");
  const std::size_t chunk = bag.find("compression=lz4");
  const std::size_t size = bag.find("size=", chunk);
  ASSERT_NE(size, std::string::npos);
  bag.replace(size + 5, 4, std::string("\0\0\0\x80", 4));
  EXPECT_HAS(error(write("large.bag", bag).string() + ":/mono8"),
             "has a chunk of 2147483648 bytes");
  McapWriter one("/camera");
  one.add_chunk("zstd", "no frame", limits::kMaxBagChunkBytes + 1);
  EXPECT_HAS(error(write("chunk.mcap", one.bytes())), "has a chunk of");
  // Chunks of the largest size, of which the second one is too much for so short a file.
  McapWriter many("/camera");
  many.add_chunk("zstd", "no frame", limits::kMaxBagBytesOfFewBytes + 1);
  EXPECT_HAS(error(write("many.mcap", many.bytes())), "times its length");
  // An unknown compression is named.
  McapWriter unknown("/camera");
  unknown.add_chunk("brotli", "bytes", 10);
  EXPECT_HAS(error(write("unknown.mcap", unknown.bytes())), "compressed by \"brotli\"");
}

// A frame of Zstandard or LZ4 that holds more than its chunk says.
TEST_F(Bag, BombsEndWhereTheirSizeIs) {
  for (const auto& [kind, option] : {std::pair{"zstd", ""}, {"lz4", "--format=lz4"}}) {
    const fs::path packed = folder_ / kind;
    const std::string command = "head -c 300000000 /dev/zero | zstd -q -c " + std::string(option) +
                                " >" + packed.string() + " 2>/dev/null";
    if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs zstd";
    McapWriter bomb("/camera");
    bomb.add(McapWriter::message(Image8({8, 6}), 3));
    bomb.add_chunk(kind, read_text(packed), 1000);
    const ImageSequence about = read_sequence(write(std::string(kind) + ".mcap", bomb.bytes()));
    EXPECT_EQ(about.times_s.size(), 1U);
    EXPECT_TRUE(about.is_cut_off);
  }
}

TEST_F(Bag, TablesThatRunCodeAreRefused) {
  const fs::path file = folder_ / "view.db3";
  const std::string command =
      "sqlite3 '" + file.string() +
      "' \"CREATE TABLE topics(id, name, type, serialization_format); CREATE VIEW messages AS WITH "
      "RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS topic_id, 0 AS "
      "timestamp, x'00' AS data FROM n;\" 2>/dev/null";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs sqlite3";
  EXPECT_HAS(error(file), "is no bag of ROS 2");
}

TEST_F(Bag, WrongFilesAreOneLine) {
  EXPECT_EQ(error(folder_ / "none.bag"), (folder_ / "none.bag").string() + ": no such file");
  for (const char* name : {"a.bag", "a.mcap", "a.db3"})
    for (const char* text : {"", "hello", "#ROSBAG V1.2\n"}) {
      const std::string message = error(write(name, text));
      EXPECT_EQ(message.find((folder_ / name).string() + ": is no "), 0U) << message;
    }
  fs::create_directory(folder_ / "empty");
  EXPECT_HAS(error(folder_.string() + "/empty:/mono8"), "has no bags");
}

TEST(BagPath, IsToldFromOtherFiles) {
  const auto frame = frame_of("a/b.MCAP:/camera/image_raw@000123");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->sequence, "a/b.MCAP:/camera/image_raw");
  EXPECT_EQ(frame->frame, 123U);
  EXPECT_EQ(sequence_name(frame->sequence), "b");
  EXPECT_EQ(files_of_sequence(frame->sequence), std::vector<fs::path>{"a/b.MCAP"});
  EXPECT_TRUE(is_sequence_name("a.bag"));
  EXPECT_FALSE(is_sequence_name("a.png:/camera"));
}

}  // namespace
}  // namespace tagcal
