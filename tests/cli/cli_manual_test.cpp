#include "cli_fixture.hpp"

// The guide, manual pages and completions, made from the same descriptions as --help.

namespace tagcal::tools {
namespace {

TEST_F(Cli, AloneItShowsAGuide) {
  const Outcome guide = good_run("");
  EXPECT_EQ(guide.err, "");
  std::istringstream lines(guide.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  for (const char* command :
       {"board ", "calibrate ", "watch ", "pose ", "detect ", "reproject ", "diff "})
    EXPECT_HAS(guide.out, std::string("tagcal ") + command);
}

TEST_F(Cli, TheVersionNamesTheLibraries) {
  const Outcome version = good_run("--version");
  for (const char* library : {"Ceres 2", "OpenCV 4", "Eigen 3", "AprilTag 3"})
    EXPECT_HAS(version.out, library);
}

constexpr const char* kCommands[] = {
    "",        "render",    "detect",      "calibrate", "rig",       "handeye",
    "watch",   "validate",  "check",       "report",    "pose",      "board",
    "view",    "diff",      "history",     "fleet",     "convert",   "reproject",
    "project", "unproject", "triangulate", "chart",     "stability", "completion"};

// As wide as the terminal says, 100 columns elsewhere; the seldom options are in --help-all.
TEST_F(Cli, HelpFitsATerminal) {
  for (const std::string command : kCommands)
    for (const unsigned columns : {80u, 100u, 0u}) {
      setenv("COLUMNS", std::to_string(columns).c_str(), 1);
      const std::string help = run(command + " --help").out;
      unsetenv("COLUMNS");
      std::istringstream lines(help);
      long count = 0;
      for (std::string line; std::getline(lines, line) && !line.starts_with("more:"); ++count)
        EXPECT_LE(line.size(), columns == 0 ? 100u : columns) << command << ": " << line;
      EXPECT_LE(count, 40) << command;
      for (const char* const foreign : {"TEXT", "REQUIRED", "Excludes", "Needs"})
        EXPECT_LACKS(help, foreign) << command;
    }
}

TEST_F(Cli, HelpIsInGroups) {
  const std::string help = run("calibrate --help").out, all = run("calibrate --help-all").out;
  std::size_t before = 0;
  for (const char* const group : {"\nInput:\n", "\nModel:\n", "\nOutput:\n", "\nSpeed:\n"}) {
    EXPECT_GT(help.find(group), before) << help;
    before = help.find(group);
  }
  EXPECT_HAS(help, "\nmore: tagcal calibrate --help-all\n");
  EXPECT_LACKS(help, "--sigma-px");
  EXPECT_HAS(all, "--sigma-px");
  EXPECT_EQ(run("help calibrate").out, help);
  EXPECT_EQ(run("help").out, run("--help").out);
  EXPECT_HAS(run("--help-all").out, "--px-per-deg");
  expect_bad_input("help calibrat", {"did you mean calibrate?"});
}

TEST_F(Cli, UsageErrorsAreInOurWords) {
  expect_bad_input("--verison", {"--verison: unknown option (did you mean --version?)"});
  expect_bad_input("calibrate", {"needs DATASET|IMAGE: a folder"});
  expect_bad_input("calibrate --out", {"--out: needs a value"});
  expect_bad_input("calibrate x --model opencv",
                   {"got opencv (did you mean opencv4, opencv5 or opencv8?)"});
  expect_bad_input("detect x --refinement edge",
                   {"must be fit, edges or stock, got edge (did you mean edges?)"});
  expect_bad_input("view x --steps --json", {"--steps, --json: only one of the two is possible"});
  expect_bad_input("board x", {"needs --out: file to write"});
}

TEST_F(Cli, TheStudiesHaveTheirOwnHelp) {
  const std::string out = path("study_help.txt");
  const std::string program = fs::path(TAGCAL_COMMAND).parent_path() / "tagcal-study";
  ASSERT_EQ(std::system((program + " --help >" + out).c_str()), 0);
  const std::string help = slurp(out);
  EXPECT_HAS(help, "Usage: tagcal-study ");
  EXPECT_HAS(help, "Example: tagcal-study ");
  EXPECT_HAS(run("chart --help").out, "Usage: tagcal chart ");
}

// Each command has a page with all of its long options; each script knows all of them.
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
    std::istringstream help(run(command + " --help-all").out);
    for (std::string word; help >> word;) {
      if (!word.starts_with("--") || word.find_first_of("',.:;)") != std::string::npos) continue;
      std::string dashes = word;
      for (std::size_t at = 0; (at = dashes.find('-', at)) != std::string::npos; at += 2)
        dashes.insert(at, "\\");
      EXPECT_HAS(page, dashes) << command << " " << word;
      for (const std::string& script : {bash, zsh}) EXPECT_HAS(script, word) << command;
      EXPECT_HAS(fish, "-l " + word.substr(2) + " ") << command << " " << word;
    }
  }
  EXPECT_HAS(bash, "calibrate:--model) COMPREPLY=($(compgen -W 'auto weak f ");
  EXPECT_HAS(bash, "rig:--model) ");
  for (const std::string command : {"detect", "pose"})
    EXPECT_HAS(bash, command + ":--family) COMPREPLY=($(compgen -W 'tag");
  EXPECT_HAS(bash, "detect:--refinement) COMPREPLY=($(compgen -W 'fit edges stock'");
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
