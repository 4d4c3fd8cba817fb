#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tagcal/estimate/findings.hpp"

namespace tagcal {
namespace {

std::set<std::string> documented_codes() {
  std::ifstream page(TAGCAL_SOURCE_DIR "/docs/reference/findings.md");
  std::stringstream text;
  text << page.rdbuf();
  const std::string all = text.str();
  const std::regex row(R"(\n\| `([a-z_]+)` \|)");
  std::set<std::string> codes;
  for (auto m = std::sregex_iterator(all.begin(), all.end(), row); m != std::sregex_iterator(); ++m)
    codes.insert((*m)[1]);
  return codes;
}

TEST(Findings, EveryCodeIsInTheDocumentation) {
  std::ifstream header(TAGCAL_SOURCE_DIR "/lib/tagcal/estimate/findings.hpp");
  const std::regex definition(R"re(inline constexpr FindingCode ([a-z_]+)\{"([a-z_]+)", ?)re");
  std::set<std::string> codes;
  std::size_t defined = 0;
  for (std::string line; std::getline(header, line);) {
    defined += line.starts_with("inline constexpr FindingCode ");
    std::smatch name;
    if (!std::regex_search(line, name, definition)) continue;
    EXPECT_EQ(name[1], name[2]);
    EXPECT_TRUE(codes.emplace(name[2]).second) << name[2] << " stands twice";
  }
  EXPECT_EQ(codes.size(), defined);
  EXPECT_EQ(codes, documented_codes());
}

TEST(Findings, EveryStatusThatIsNoAnswerHasACode) {
  for (const Status status :
       {Status::focal_not_observable, Status::not_observable, Status::degenerate,
        Status::no_consensus, Status::not_converged, Status::not_connected,
        Status::extrinsic_not_observable, Status::not_synchronous, Status::rotation_axes_parallel,
        Status::no_rotation, Status::wrong_direction}) {
    EXPECT_TRUE(documented_codes().contains(std::string(refusal_code(status).name)));
    EXPECT_EQ(refusal_code(status).severity, Severity::refusal);
    const Finding refusal = finding(refusal_code(status), "");
    EXPECT_EQ(judge({&refusal, 1}), status);
  }
}

}  // namespace
}  // namespace tagcal
