// Videos that ffmpeg wrote from pictures are read back: frames, order, rotation, times, damage.
#include "tagcal/io/sequence_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>

#include "file_fixture.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

bool are_equal(const Image8& a, const Image8& b) {
  if (a.size() != b.size()) return false;
  for (int y = 0; y < a.height(); ++y)
    if (!std::equal(a.row(y), a.row(y) + a.width(), b.row(y))) return false;
  return true;
}

class VideoFile : public FileTest {
 protected:
  static constexpr int kFrames = 20;

  void SetUp() override {
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "needs ffmpeg";
    for (int i = 0; i < kFrames; ++i) {
      Image8 image({64, 48});
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
          image(x, y) = static_cast<std::uint8_t>(16 + 3 * x + (y < 24 ? 0 : 2 * i));
      write_png(folder_ / ("p" + std::to_string(100 + i) + ".png"), image);
      frames_.push_back(std::move(image));
    }
  }

  fs::path encoded(const std::string& name, const std::string& options) {
    const fs::path file = folder_ / name;
    const std::string command = "ffmpeg -loglevel error -y -framerate 10 -start_number 100 -i '" +
                                (folder_ / "p%d.png").string() + "' " + options + " '" +
                                file.string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return file;
  }

  std::vector<Image8> frames_;
};

TEST_F(VideoFile, ALosslessOneIsItsPictures) {
  const fs::path file = encoded("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  const ImageSequence video = read_sequence(file);
  EXPECT_EQ(video.size, (ImageSize{64, 48}));
  ASSERT_EQ(video.times_s.size(), frames_.size());
  for (int i = 0; i < kFrames; ++i) EXPECT_NEAR(video.times_s[i], 0.1 * i, 1e-9);
  EXPECT_FALSE(video.is_uneven);
  EXPECT_FALSE(video.is_interlaced);
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    EXPECT_TRUE(are_equal(read_image(frame_path(file, i)), frames_[i])) << i;
    EXPECT_EQ(read_image_size(frame_path(file, i)), video.size);
  }
  const auto colour = std::get<ImageRgb>(read_picture(frame_path(file, 3)));
  EXPECT_EQ(colour(10, 5), (Rgb{frames_[3](10, 5), frames_[3](10, 5), frames_[3](10, 5)}));
}

TEST_F(VideoFile, FramesAreFoundInAnyOrderByAnyThreads) {
  // With frames that are decoded in another order than they are shown.
  const fs::path file = encoded("clip.mp4", "-c:v libx264 -qp 0 -bf 3 -g 7 -pix_fmt yuv444p");
  std::vector<Image8> expected;
  for (std::size_t i = 0; i < frames_.size(); ++i)
    expected.push_back(read_image(frame_path(file, i)));
  for (std::size_t i = 0; i < frames_.size(); ++i)
    EXPECT_NEAR(expected[i](10, 40), frames_[i](10, 40), 2) << i;
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t t = 0; t < wrong.size(); ++t)
    threads.emplace_back([&, t] {
      std::minstd_rand random(static_cast<unsigned>(t + 1));
      for (int k = 0; k < 100; ++k) {
        const std::size_t i = random() % expected.size();
        wrong[t] += !are_equal(read_image(frame_path(file, i)), expected[i]);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST_F(VideoFile, IsTurnedAsAPhoneSays) {
  const fs::path flat = encoded("flat.mp4", "-c:v libx264 -qp 0 -pix_fmt yuv444p");
  const fs::path turned = folder_ / "turned.mov";
  ASSERT_EQ(std::system(("ffmpeg -loglevel error -y -i '" + flat.string() +
                         "' -c copy -metadata:s:v rotate=90 '" + turned.string() + "'")
                            .c_str()),
            0);
  EXPECT_EQ(read_sequence(turned).size, (ImageSize{48, 64}));
  const Image8 lying = read_image(frame_path(flat, 4)), upright = read_image(frame_path(turned, 4));
  ASSERT_EQ(upright.size(), (ImageSize{48, 64}));
  // As ffmpeg itself turns it: the upper right pixel comes to the upper left.
  EXPECT_EQ(upright(0, 0), lying(63, 0));
  EXPECT_EQ(upright(47, 63), lying(0, 47));
}

TEST_F(VideoFile, OneThatIsCutOffHasTheFramesUntilThere) {
  const std::pair<std::string, std::string> kinds[] = {
      {"clip.avi", "-c:v ffv1 -pix_fmt gray"},
      {"clip.mkv", "-c:v ffv1 -pix_fmt gray"},
      {"clip.mov", "-c:v png -pix_fmt gray -movflags +faststart"}};
  for (const auto& [name, options] : kinds) {
    SCOPED_TRACE(name);
    const fs::path file = encoded(name, options);
    EXPECT_FALSE(read_sequence(file).is_cut_off);
    const fs::path cut = folder_ / ("cut_" + name);
    fs::copy_file(file, cut);
    fs::resize_file(cut, fs::file_size(cut) / 2);
    const ImageSequence video = read_sequence(cut);
    EXPECT_TRUE(video.is_cut_off);
    EXPECT_GT(video.times_s.size(), 2U);
    EXPECT_LT(video.times_s.size(), 15U);
    EXPECT_TRUE(are_equal(read_image(frame_path(cut, 2)), frames_[2]));
    EXPECT_THROW(read_image(frame_path(cut, 19)), Error);
  }
}

TEST_F(VideoFile, CutsAndDamageThrowOrGiveFrames) {
  const fs::path whole = encoded("clip.mkv", "-c:v libx264 -crf 30 -pix_fmt yuv420p");
  const std::string bytes = read_text(whole);
  std::minstd_rand random(5);
  const auto try_all = [&](const std::string& damaged, const std::string& name) {
    const fs::path file = folder_ / name;
    std::ofstream(file, std::ios::binary) << damaged;
    try {
      const std::size_t count = read_sequence(file).times_s.size();
      for (std::size_t i = 0; i < count; i += 5) read_image(frame_path(file, i));
    } catch (const Error&) {
    }
  };
  for (std::size_t size = 0; size < bytes.size(); size += 256)
    try_all(bytes.substr(0, size), "cut" + std::to_string(size) + ".mkv");
  for (int i = 0; i < 60; ++i) {
    std::string damaged = bytes;
    for (int k = 0; k < 5; ++k)
      damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    try_all(damaged, "damaged" + std::to_string(i) + ".mkv");
  }
}

TEST_F(VideoFile, ErrorsSayWhat) {
  EXPECT_ERROR(read_sequence(folder_ / "none.mp4"),
               (folder_ / "none.mp4").string() + ": no such file");
  write_png(folder_ / "picture.png", frames_[0]);
  fs::rename(folder_ / "picture.png", folder_ / "picture.mp4");
  EXPECT_HAS(error_of([&] { read_sequence(folder_ / "picture.mp4"); }), "is no video");
  // A playlist would make the reader open other files.
  std::ofstream(folder_ / "list.mp4") << "#EXTM3U\n#EXTINF:1,\nclip.mkv\n#EXT-X-ENDLIST\n";
  EXPECT_HAS(error_of([&] { read_sequence(folder_ / "list.mp4"); }), "is no video");
  const fs::path file = encoded("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  const std::string beyond = error_of([&] { read_image(frame_path(file, 20)); });
  EXPECT_HAS(beyond, "has 20 frames, the last one is number 19");
}

TEST(FramePath, IsToldFromOtherFiles) {
  const auto frame = frame_of("a/clip.MP4@000123");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->sequence, "a/clip.MP4");
  EXPECT_EQ(frame->frame, 123U);
  EXPECT_EQ(frame_of(frame_path("clip.mkv", 1234567))->frame, 1234567U);
  for (const char* other : {"clip.mp4", "clip.mp4@12", "clip.png@000123", "clip.mp4@00012x",
                            "@000001", "clip.mp4@99999999999999999999999"})
    EXPECT_FALSE(frame_of(other)) << other;
}

}  // namespace
}  // namespace tagcal
