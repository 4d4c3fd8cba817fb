// Runs the tests of one file: `<program> lens_test`; all of them without a name. GoogleTest's own
// options come after it.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace {

// Of the tests that stand in <name>.cpp, for --gtest_filter.
std::string names_of_tests_in(const std::string& name) {
  std::string names;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const testing::TestSuite& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k) {
      const testing::TestInfo& test = *suite.GetTestInfo(k);
      if (std::filesystem::path(test.file()).stem() == name)
        names += std::string(suite.name()) + '.' + test.name() + ':';
    }
  }
  return names;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    const std::string names = names_of_tests_in(argv[1]);
    if (names.empty()) {
      std::fprintf(stderr, "%s: no test of that name\n", argv[1]);
      return 2;
    }
    testing::GTEST_FLAG(filter) = names;
  }
  return RUN_ALL_TESTS();
}
