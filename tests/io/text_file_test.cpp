#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "file_fixture.hpp"

namespace tagcal {
namespace {

class TextFile : public FileTest {};

TEST_F(TextFile, GivesBackWhatWasWritten) {
  const fs::path file = folder_ / "a.txt";
  for (const std::string& text :
       {std::string(), std::string("a"), std::string("\0\r\n\xff", 4), std::string(3 << 20, 'x')}) {
    write_whole(file, text);
    EXPECT_TRUE(read_text(file) == text);
    EXPECT_EQ(num_files(), 1U);
  }
}

TEST_F(TextFile, AByteOrderMarkIsNoText) {
  const fs::path file = folder_ / "a.txt";
  const std::string mark = "\xEF\xBB\xBF";
  for (const auto& [written, text] : {std::pair(mark + "a", std::string("a")),
                                      {mark, ""},
                                      {mark + mark + "a", mark + "a"},
                                      {"a" + mark, "a" + mark},
                                      {"\xEF\xBB", "\xEF\xBB"}}) {
    write_whole(file, written);
    EXPECT_EQ(read_text(file), text);
    EXPECT_EQ(read_plain_text(file), text);
  }
}

TEST_F(TextFile, ReadingNamesTheFileAndTheReason) {
  EXPECT_ERROR(read_text(folder_ / "none"), (folder_ / "none").string() + ": no such file");
  EXPECT_ERROR(read_text(folder_), folder_.string() + ": is a folder, not a file");
  const fs::path big = folder_ / "big";
  std::ofstream(big).put('x');
  fs::resize_file(big, (std::uintmax_t{256} << 20) + 1);  // sparse: takes no room
  EXPECT_ERROR(read_text(big), big.string() + ": larger than 256 MiB");
  write_whole(folder_ / "a", "x");
  EXPECT_ERROR(read_text(folder_ / "a" / "b"), (folder_ / "a" / "b").string() + ": no such file");
}

TEST_F(TextFile, ReadsPipesAndNoDevices) {
  for (const char* device : {"/dev/zero", "/dev/null", "/dev/tty"}) {
    if (!fs::exists(device)) continue;
    EXPECT_ERROR(read_text(device), std::string(device) + ": is a device, not a file");
  }
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_text(pipe), "");  // nobody writes: it does not wait

  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::string text(1 << 20, 'x');  // more than a pipe holds at a time
  std::thread writer([&] {
    EXPECT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    ::close(ends[1]);
  });
  EXPECT_TRUE(read_text("/dev/fd/" + std::to_string(ends[0])) == text);
  writer.join();
  ::close(ends[0]);
}

TEST_F(TextFile, WritingWhereItCannotIsAnErrorAndLeavesNothing) {
  EXPECT_HAS(error_of([&] { write_whole(folder_ / "no" / "file", "x"); }), "no/file: cannot");
  fs::create_directory(folder_ / "sub");
  EXPECT_HAS(error_of([&] { write_whole(folder_ / "sub", "x"); }), "sub: cannot write");
  EXPECT_HAS(error_of([&] { write_whole(folder_ / "sub/", "x"); }), "cannot write");
  EXPECT_HAS(error_of([&] { write_whole("", "x"); }), "cannot write");
  EXPECT_EQ(num_files(), 1U);
}

// A limit on the size of files simulates a full disk.
TEST_F(TextFile, FailedWriteKeepsTheOldFileAndRemovesTheTemporary) {
  const fs::path file = folder_ / "a.txt";
  write_whole(file, "old");
  ::rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  ::rlimit small = before;
  small.rlim_cur = 4096;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = error_of([&] { write_whole(file, std::string(1 << 16, 'x')); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_HAS(message, "a.txt: cannot write: File too large");
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(num_files(), 1U);
}

TEST_F(TextFile, KeepsLinksAndPermissions) {
  const fs::path file = folder_ / "a.txt";
  const fs::path link = folder_ / "link";
  write_whole(file, "old");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("a.txt", link);
  write_whole(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(read_text(file), "new");
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(TextFile, WritingDoesNotWaitForAReader) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_ERROR(write_whole(pipe, "x"), pipe.string() + ": cannot write: nobody reads this pipe");
  std::string read;
  std::thread reader([&] { std::ifstream(pipe) >> read; });
  write_whole(pipe, "text");
  reader.join();
  EXPECT_EQ(read, "text");
  EXPECT_EQ(num_files(), 1U);
}

TEST_F(TextFile, KeepsALoopOfLinks) {
  fs::create_symlink("b", folder_ / "a");
  fs::create_symlink("a", folder_ / "b");
  EXPECT_ERROR(write_whole(folder_ / "a", "x"),
               (folder_ / "a").string() + ": cannot write: Too many levels of symbolic links");
  EXPECT_TRUE(fs::is_symlink(folder_ / "a"));
  EXPECT_EQ(num_files(), 2U);
}

// A process of the same number, killed before or in another container, may have left its files.
TEST_F(TextFile, TemporaryFilesOfOthersDoNotDisturb) {
  for (int i = 0; i < 100; ++i)
    write(".tagcal-" + std::to_string(::getpid()) + "-" + std::to_string(i) + ".tmp", "other");
  write_whole(folder_ / "a", "x");
  EXPECT_EQ(read_text(folder_ / "a"), "x");
  EXPECT_EQ(num_files(), 101U);
}

TEST_F(TextFile, DoesNotReplaceADevice) {
  EXPECT_NO_THROW(write_whole("/dev/null", "x"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace tagcal
