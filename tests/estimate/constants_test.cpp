// Every number that decides something stands in the policy file of its layer.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

namespace tagcal {
namespace {

namespace fs = std::filesystem;

struct Count {
  std::vector<std::string> offences;  // "file:line: text"
  int num_numeric = 0;                // lines with a constant that are marked
};

// Literals that are not whole numbers, in a line of code without its texts and comments.
bool has_constant(std::string line) {
  static const std::regex escaped(R"(\\")"), text(R"("[^"]*")"), comment("//.*");
  static const std::regex number(
      R"((^|[^A-Za-z0-9_.])([0-9']*\.[0-9]*[1-9][0-9]*(e-?[0-9]+)?|[0-9]+(\.[0-9]*)?e-[0-9]+))");
  line = std::regex_replace(line, escaped, "");
  line = std::regex_replace(line, text, "\"\"");
  line = std::regex_replace(line, comment, "");
  return std::regex_search(line, number);
}

bool is_comment(const std::string& line) {
  const std::size_t first = line.find_first_not_of(' ');
  return first != std::string::npos && line.compare(first, 2, "//") == 0;
}

// A line is marked by `// numeric: why` at its end, or by a line of comment above it.
void check(std::istream& file, const std::string& name, Count& count) {
  bool excused = false;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    static const std::regex mark("// numeric: [A-Za-z0-9]");
    const bool marked = std::regex_search(line, mark);
    if (has_constant(line)) {
      if (marked || excused)
        ++count.num_numeric;
      else
        count.offences.push_back(name + ":" + std::to_string(number) + ": " + line);
    }
    excused = is_comment(line) && (marked || excused);
  }
}

Count checked(const std::string& text) {
  Count count;
  std::istringstream file(text);
  check(file, "text", count);
  return count;
}

class ConstantsOf : public testing::TestWithParam<const char*> {};

TEST_P(ConstantsOf, StandInThePolicyFile) {
  Count count;
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(TAGCAL_SOURCE_DIR) / "lib" /
                                                            "tagcal" / GetParam())) {
    const std::string name = entry.path().string();
    if (!entry.is_regular_file() || name.find("/policy/") != std::string::npos) continue;
    std::ifstream file(entry.path());
    check(file, name, count);
    ++files;
  }
  EXPECT_GT(files, 4);
  for (const std::string& offence : count.offences) ADD_FAILURE() << offence;
  RecordProperty("numeric", count.num_numeric);
  std::printf("%s: %d lines are marked numeric\n", GetParam(), count.num_numeric);
}

INSTANTIATE_TEST_SUITE_P(Layers, ConstantsOf, testing::Values("uncertainty", "estimate", "detect"));

TEST(Constants, TheCheckFailsWhereItMust) {
  for (const char* fine :
       {"int a = 12;", "double a = 2.0;", "double a = 1e300;", "b2 = a1[0];  // 0.5 in words",
        "text(\"0.5 px\");", "double a = 1e-12;  // numeric: rounding",
        "// numeric: rounding\ndouble a = 1e-12;",
        "// numeric: rounding, which\n// is small\ndouble a = 1e-12;"})
    EXPECT_TRUE(checked(fine).offences.empty()) << fine;
  for (const char* wrong :
       {"double a = 0.3;", "double a = 1e-12;", "double a = .25;", "if (x > 2.5e3) return;",
        "double a = 0.3;  // numeric", "// numeric: rounding\ndouble a = 1e-12;\ndouble b = 0.3;"})
    EXPECT_EQ(checked(wrong).offences.size(), 1u) << wrong;
}

}  // namespace
}  // namespace tagcal
