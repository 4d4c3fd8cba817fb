// The command with stderr closed or full has the same exit codes and results.
#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>

#include "cli_fixture.hpp"
#include "cli_process.hpp"
#include "job/terminal.hpp"
#include "watch/live_frames.hpp"

namespace tagcal::tools {
namespace {

class CliStreams : public Cli {
 protected:
  // As run(), with `redirection` for stderr.
  static Outcome run_with(const std::string& redirection, const std::string& arguments) {
    const std::string out = path("stdout.txt");
    const std::string line =
        std::string(TAGCAL_COMMAND) + " " + arguments + " >" + out + " </dev/null " + redirection;
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), ""};
  }
};

// Without the last line, which has the times.
std::string without_time(const std::string& text) { return text.substr(0, text.find("\ntime ")); }

TEST_F(CliStreams, ExitCodesDoNotDependOnStderr) {
  const std::string set = path("set");
  const std::vector<std::string> commands = {
      "detect " + set,
      "detect " + path("nothing"),
      "calibrate " + set + " --model f --out " + path("camera.yaml"),
      "board " + path("set/target.yaml") + " --out " + path("board.svg"),
      "frobnicate",
      "calibrate --modle f " + set};
  for (const std::string& command : commands) {
    const Outcome usual = run(command);
    for (const std::string redirection : {"2>&-", "2>/dev/full"}) {
      const Outcome outcome = run_with(redirection, command);
      EXPECT_EQ(outcome.exit_code, usual.exit_code) << command << " " << redirection;
      EXPECT_EQ(without_time(outcome.out), without_time(usual.out)) << command << redirection;
    }
  }
}

TEST_F(CliStreams, CornersComeFromStdin) {
  const std::string corners = path("set/observations_exact.csv");
  const std::string calibrate = "calibrate " + path("set") + " --observations ";
  const Outcome usual = good_run(calibrate + corners);
  const Outcome piped = run_with("2>/dev/null <" + corners, calibrate + "-");
  EXPECT_EQ(piped.exit_code, 0);
  EXPECT_EQ(without_time(piped.out), without_time(usual.out));
}

// Lines of messages that are not our own.
std::vector<std::string> foreign_lines(const std::string& err) {
  std::vector<std::string> foreign;
  std::istringstream lines(without_progress(err));
  for (std::string line; std::getline(lines, line);) {
    bool own = line.empty();
    // Messages, files, and summaries beside a result on stdout.
    for (const char* start :
         {"tagcal: ", "wrote ", "OK", "PARTLY: ", "NOTHING FOUND: ", "0 of 1 view "})
      own = own || line.starts_with(start);
    if (!own) foreign.push_back(line);
  }
  return foreign;
}

// Ceres finds no value at its start with these coefficients, and logs it; noise has many shapes
// that are no tags. Studies: quiet_peers_test.
TEST_F(CliStreams, MessagesAreOurOwn) {
  const std::string set = path("set"), camera = path("own.yaml"), noise = path("noise.pgm");
  std::string pixels = "P5 640 400 255\n";
  unsigned state = 1;
  for (int i = 0; i < 640 * 400; ++i)
    pixels += static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  spill(noise, pixels);
  const std::string target = " --target " + path("set/target.yaml");
  ASSERT_EQ(run("calibrate " + set + " --model f --out " + camera).exit_code, 0);
  for (const std::string& command :
       {"calibrate " + set + " --model opencv5 --fix k1=-5 --keep-all",
        "calibrate " + set + " --model radial2 --fix k1=-3 --keep-all --threads 2",
        "calibrate " + set + " " + set + " --model opencv5 --fix k1=-5 --keep-all",
        "calibrate " + noise + target, "detect " + noise + target + " --out " + path("noise.csv"),
        "pose " + noise + target + " --camera " + camera + " --out " + path("poses.json"),
        "validate " + camera + " --dataset " + set, "diff " + camera + " " + camera,
        "report " + camera + " --dataset " + set + " --out " + path("own.html")}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(foreign_lines(outcome.err), std::vector<std::string>()) << command;
  }
}

// What a program prints on a terminal of its own.
class Terminal {
 public:
  Terminal() : master_(posix_openpt(O_RDWR | O_NOCTTY)) {
    grantpt(master_);
    unlockpt(master_);
    slave_ = open(name().c_str(), O_RDWR | O_NOCTTY);  // keeps what is printed until it is read
    fcntl(master_, F_SETFL, O_NONBLOCK);
  }
  ~Terminal() {
    close(slave_);
    close(master_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  std::string name() const { return ptsname(master_); }
  std::string printed() const {
    std::string text, block(4096, '\0');
    for (ssize_t n = 0; (n = read(master_, block.data(), block.size())) > 0;)
      text.append(block, 0, static_cast<std::size_t>(n));
    return text;
  }

 private:
  int master_, slave_;
};

TEST(Terminal, ControlCharactersAreShown) {
  EXPECT_EQ(without_controls("a\033]0;b\a\r\x7f c\n\td"), "a?]0;b??? c\n\td");
  EXPECT_EQ(without_controls("\xc2\x9b"
                             "2J \xc3\xa9 \xc2\xb5 \xc2"),
            "?2J \xc3\xa9 \xc2\xb5 \xc2");
  EXPECT_EQ(without_controls("\033[1;32mok\033[0m \033[2J \033[1;3"),
            "\033[1;32mok\033[0m ?[2J ?[1;3");
}

// Names of pictures may hold any bytes, those that clear a terminal too. Data keep them.
TEST_F(CliStreams, NamesDoNotCommandATerminal) {
  const std::string name = "\033[2J\a.png", csv = path("names.csv");
  fs::create_directories(path("names"));
  for (const char* const copy : {"a", "b"})
    fs::copy(path("set/images/000.png"), path("names/" + (copy + name)));
  const std::string detect = "detect " + path("names") + " --target " + path("set/target.yaml");
  const Outcome bad = run("detect 'no" + name + "' --target " + path("set/target.yaml"));
  EXPECT_HAS(bad.err, "no?[2J?.png: matches no file");
  EXPECT_EQ(run(detect + " --no-cache --out " + csv).exit_code, 0);
  EXPECT_HAS(slurp(csv), "a" + name);
  const Terminal terminal;
  const std::string calibrate = "calibrate " + path("names") + " --no-cache --target " +
                                path("set/target.yaml") + " --model f";
  std::system((program() + " " + calibrate + " >" + terminal.name() + " 2>&1").c_str());
  const std::string printed = terminal.printed();
  EXPECT_HAS(printed, "a?[2J?.png");
  EXPECT_LACKS(printed, "\033[2J");
}

// Parts end anywhere, and there are many: each byte is looked at once. 16 MiB of these bytes in
// parts of 1 KiB, each time from the beginning, would take minutes.
TEST(FrameStream, APictureComesInManyParts) {
  const std::string start = "\xff\xd8\xff", end = "\xff\xd9";
  const std::string picture = start + std::string(1 << 24, '\xff') + end;
  const std::string video = picture + start + end + start;
  const auto stream = frame_stream(video.substr(0, 64));
  ASSERT_TRUE(stream);
  std::vector<std::string> frames;
  const std::clock_t before = std::clock();
  for (std::size_t at = 0; at < video.size();) {
    const std::size_t size = at + 1024 < picture.size() ? 1024 : 1;
    stream->add(std::string_view(video).substr(at, size));
    at += size;
    while (const auto frame = stream->next(false)) frames.push_back(frame->jpeg);
  }
  EXPECT_LT(std::clock() - before, 10 * CLOCKS_PER_SEC);
  EXPECT_TRUE(frames == (std::vector{picture, start + end}));  // not printed
  EXPECT_EQ(stream->next(true)->jpeg, start);
}

// A data set whose files are elsewhere, read and written through `..` and symbolic links.
TEST_F(CliStreams, DotsAndSymbolicLinksWork) {
  const fs::path here = root() / "links/here";
  fs::create_directories(here);
  fs::create_directory_symlink("../set", root() / "links/set");
  fs::create_symlink("real.yaml", root() / "links/linked.yaml");
  spill(root() / "links/real.yaml", "old");
  spill(here / "dataset.yaml",
        "image_size: [640, 400]\ntarget: ../set/target.yaml\nimages: ../../set/images\n");
  const std::string calibrate = "calibrate --no-cache --model radial1 ";
  ASSERT_EQ(run(calibrate + path("set") + " --out " + path("plain.yaml")).exit_code, 0);
  const std::string plain = slurp(root() / "plain.yaml");
  const Outcome linked = good_run(calibrate + path("links/here/../set") + " --out " +
                                  path("links/here/../linked.yaml"));
  EXPECT_TRUE(fs::is_symlink(root() / "links/linked.yaml"));
  EXPECT_EQ(slurp(root() / "links/real.yaml"), plain);
  const Outcome dots = good_run(calibrate + path("links/here") + " --out " + path("dots.yaml"));
  EXPECT_EQ(slurp(root() / "dots.yaml"), plain);
}

// A result that is lost is no success, and that of a file is none.
TEST_F(CliStreams, AResultThatCannotBePrintedIsAnError) {
  const std::string set = path("set");
  for (const std::string& command :
       {std::string(), std::string("--help"), std::string("--version"), std::string("pose --help"),
        "detect " + set, "calibrate " + set + " --model f", std::string("completion bash")})
    for (const std::string redirection : {">&-", ">/dev/full"})
      EXPECT_EQ(run_with("2>/dev/null " + redirection, command).exit_code, 2)
          << command << " " << redirection;
}

// Notes about one input are no second line beside the error of another.
TEST_F(CliStreams, NotesWaitUntilAllInputsAreRead) {
  const std::string camera =
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
      "camera_matrix: !!opencv-matrix {rows: 3, cols: 3, dt: d, data: [500, 0, 320, 0, 500, 240, "
      "0, 0, 1]}\n"
      "distortion_coefficients: !!opencv-matrix {rows: 1, cols: 14, dt: d, data: [0, 0, 0, 0, 0, "
      "0, 0, 0, 0, 0, 0, 0, 0, 0]}\n";
  spill(root() / "prisms.yml", camera);
  const Outcome same = good_run("diff " + path("prisms.yml") + " " + path("prisms.yml"));
  EXPECT_EQ(same.err,
            path("prisms.yml") + ": dropped: 6 coefficients of thin prism and tilt, which are 0\n");
  expect_bad_input("diff " + path("prisms.yml") + " " + path("nothing.yml"), {"nothing.yml"});
  expect_bad_input("pose --camera " + path("prisms.yml") + " --target " + path("set/target.yaml") +
                       " " + path("nothing.png"),
                   {"nothing.png"});
}

// It is no signal, which would leave temporary folders.
TEST_F(CliStreams, APipeThatNobodyReadsIsAnError) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[0]);
  const std::string pipe = " >&" + std::to_string(ends[1]);
  const std::string render = "render " + path("scene.yaml") + " --out " + path("piped");
  EXPECT_EQ(CliProcess("detect " + path("set") + pipe + " 2>" + path("stderr.txt")).wait(), 2);
  EXPECT_EQ(without_progress(slurp(root() / "stderr.txt")),
            "tagcal: standard output: cannot be written: Broken pipe\n");
  EXPECT_EQ(CliProcess(render + pipe + " 2>&1").wait(), 0);  // only progress and messages are lost
  EXPECT_EQ(bytes_of(root() / "piped"), bytes_of(root() / "set"));
  ::close(ends[1]);
}

// The next file that is opened would get the number of a closed stderr.
TEST_F(CliStreams, MessagesDoNotEndUpInFiles) {
  const std::string detect = "detect " + path("set") + " --out ";
  ASSERT_EQ(run(detect + path("usual.csv")).exit_code, 0);
  ASSERT_EQ(run_with("2>&-", detect + path("closed.csv")).exit_code, 0);
  EXPECT_EQ(slurp(root() / "closed.csv"), slurp(root() / "usual.csv"));
}

}  // namespace
}  // namespace tagcal::tools
