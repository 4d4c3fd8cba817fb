#include "cli_fixture.hpp"

// The guide, manual pages and completions, made from the same descriptions as --help.

namespace tagcal::tools {
namespace {

TEST_F(Cli, AloneItShowsAGuide) {
  const Outcome guide = run("");
  EXPECT_EQ(guide.exit_code, 0);
  EXPECT_EQ(guide.err, "");
  std::istringstream lines(guide.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  for (const char* command :
       {"board ", "calibrate ", "watch ", "pose ", "detect ", "reproject ", "diff "})
    EXPECT_NE(guide.out.find(std::string("tagcal ") + command), std::string::npos) << command;
}

TEST_F(Cli, TheVersionNamesTheLibraries) {
  const Outcome version = run("--version");
  EXPECT_EQ(version.exit_code, 0);
  for (const char* library : {"Ceres 2", "OpenCV 4", "Eigen 3", "AprilTag 3"})
    EXPECT_NE(version.out.find(library), std::string::npos) << version.out;
}

// Each command has a page with all of its long options; each script knows all of them.
TEST_F(Cli, HelpFitsATerminal) {
  for (const std::string command :
       {"", "render", "detect", "calibrate", "watch", "validate", "report", "pose", "board", "view",
        "diff", "convert", "reproject", "project", "unproject", "chart", "stability",
        "completion"}) {
    std::istringstream lines(run(command + " --help").out);
    for (std::string line; std::getline(lines, line);)
      EXPECT_LE(line.size(), 100u) << command << ": " << line;
  }
}

TEST_F(Cli, PagesAndCompletionsHaveAllOptions) {
  const fs::path share = root() / "share";
  ASSERT_EQ(run("completion --share " + share.string()).exit_code, 0);
  const std::string bash = slurp(share / "bash-completion/completions/tagcal");
  const std::string zsh = slurp(share / "zsh/site-functions/_tagcal");
  const std::string fish = slurp(share / "fish/vendor_completions.d/tagcal.fish");
  EXPECT_EQ(bash, run("completion bash").out);
  EXPECT_EQ(zsh, run("completion zsh").out);
  EXPECT_EQ(fish, run("completion fish").out);
  for (const std::string command :
       {"render", "detect", "calibrate", "watch", "pose", "diff", "convert"}) {
    const std::string page = slurp(share / ("man/man1/tagcal-" + command + ".1"));
    EXPECT_TRUE(page.starts_with(".TH tagcal\\-" + command)) << page;
    std::istringstream help(run(command + " --help").out);
    for (std::string word; help >> word;) {
      if (!word.starts_with("--") || word.find_first_of("',.:;)") != std::string::npos) continue;
      std::string dashes = word;
      for (std::size_t at = 0; (at = dashes.find('-', at)) != std::string::npos; at += 2)
        dashes.insert(at, "\\");
      EXPECT_NE(page.find(dashes), std::string::npos) << command << " " << word;
      for (const std::string& script : {bash, zsh})
        EXPECT_NE(script.find(word), std::string::npos) << command << " " << word;
      EXPECT_NE(fish.find("-l " + word.substr(2) + " "), std::string::npos)
          << command << " " << word;
    }
  }
  EXPECT_NE(bash.find("detect:--refinement) COMPREPLY=($(compgen -W 'fit edges stock'"),
            std::string::npos);
  EXPECT_EQ(
      std::system(("bash -n " + (share / "bash-completion/completions/tagcal").string()).c_str()),
      0);
}

TEST_F(Cli, CompletionNeedsAShellThatItKnows) {
  expect_bad_input("completion", {"bash", "--share"});
  expect_bad_input("completion tcsh", {"tcsh", "bash"});
  spill(root() / "file", "x");
  expect_bad_input("completion --share " + path("file"), {path("file")});
}

}  // namespace
}  // namespace tagcal::tools
