// tagcal project and unproject, from outside.
#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

class CliProject : public Cli {
 protected:
  void SetUp() override {
    if (fs::exists(root() / "fit.yaml")) return;
    const Outcome fit = good_run("calibrate " + path("set") + " --out " + path("fit.yaml"));
  }

  // The rows of a CSV without its header.
  static std::vector<std::vector<std::string>> rows(const std::string& text) {
    std::vector<std::vector<std::string>> table;
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
      std::vector<std::string> fields(1);
      for (const char c : line) {
        if (c == ',')
          fields.emplace_back();
        else
          fields.back() += c;
      }
      table.push_back(fields);
    }
    return table;
  }

  std::string camera() const { return " --camera " + path("fit.yaml"); }
};

TEST_F(CliProject, PointsToPixelsAndBack) {
  spill(root() / "points.csv",
        "name,x_m,y_m,z_m\nfirst,0.1,0.05,0.5\nbehind,0,0,-1\nbeside,3,0,1\n");
  const Outcome there =
      good_run("project " + path("points.csv") + camera() + " --out " + path("px.csv"));
  EXPECT_HAS(there.err, "of 3 points");
  const std::string pixels = slurp(root() / "px.csv");
  EXPECT_TRUE(
      pixels.starts_with("name,x_m,y_m,z_m,u_px,v_px,suu_px2,suv_px2,svv_px2,in_image,valid\n"))
      << pixels;
  const auto table = rows(pixels);
  ASSERT_EQ(table.size(), 3u);
  EXPECT_EQ(table[0].back(), "1");
  EXPECT_GT(std::stod(table[0][6]), 1e-6);
  EXPECT_EQ(table[1],
            (std::vector<std::string>{"behind", "0", "0", "-1", "", "", "", "", "", "", "0"}));
  EXPECT_NE(table[2][table[2].size() - 2], "1");  // not in the image
  const Outcome back = good_run("unproject " + path("px.csv") + camera() + " --depth 0.5");
  const auto again = rows(back.out);
  const std::size_t x = again[0].size() - 11;
  EXPECT_NEAR(std::stod(again[0][x]), 0.1, 1e-12);
  EXPECT_NEAR(std::stod(again[0][x + 1]), 0.05, 1e-12);
  EXPECT_EQ(again[1].back(), "0");
}

TEST_F(CliProject, PointsOfTheBoardByAViewAndBackToItsPlane) {
  spill(root() / "board.csv", "x,y,z\n0.06,0,0\n0.2,0.1,0\n");
  const std::string view = camera() + " --view 002.png";
  ASSERT_EQ(run("project " + path("board.csv") + view + " --out " + path("seen.csv")).exit_code, 0);
  const Outcome back = good_run("unproject " + path("seen.csv") + view + " --plane");
  const auto table = rows(back.out);
  const std::size_t x = table[1].size() - 11;
  EXPECT_NEAR(std::stod(table[1][x]), 0.2, 1e-12);
  EXPECT_NEAR(std::stod(table[1][x + 1]), 0.1, 1e-12);
  EXPECT_EQ(std::stod(table[1][x + 2]), 0);
  EXPECT_GT(std::stod(table[1][x + 3]), 0);
  // The corner that the detector finds there is the one that is projected: tag 0, lower right.
  const auto corners = rows(slurp(root() / "set/observations_exact.csv"));
  const auto corner = std::ranges::find_if(corners, [](const auto& row) {
    return row[0] == "002.png" && row[1] == "0" && row[2] == "1";
  });
  ASSERT_NE(corner, corners.end());
  const auto seen = rows(slurp(root() / "seen.csv"));
  EXPECT_NEAR(std::stod(seen[0][3]), std::stod((*corner)[3]), 0.1);
  EXPECT_NEAR(std::stod(seen[0][4]), std::stod((*corner)[4]), 0.1);
}

TEST_F(CliProject, NumbersThatOverflowAreNoAnswer) {
  spill(root() / "far.csv", "u_px,v_px,depth_m,sigma_depth_m\n1,2,1,1e200\n1,2,3,0.1\n");
  const Outcome far =
      good_run("unproject " + path("far.csv") + camera() + " --out " + path("xyz.csv"));
  EXPECT_HAS(far.err, "1 of 2 points; 1 have no ray");
  EXPECT_HAS(far.err, "or are beyond the range of numbers (valid = 0)");
  const std::string points = slurp(root() / "xyz.csv");
  EXPECT_LACKS(points, "inf");
  EXPECT_EQ(rows(points)[0].back(), "0");
  EXPECT_EQ(rows(points)[1].back(), "1");
  spill(root() / "px.csv", "u_px,v_px\n1,2\n");
  EXPECT_EQ(run("unproject " + path("px.csv") + camera() + " --depth 1e200").exit_code, 3);
}

// The table of `tagcal detect`, with names that need quotes, and a corner without a covariance.
TEST_F(CliProject, NamesInQuotesAreReadAndWritten) {
  spill(root() / "seen.csv",
        "image,tag_id,corner,x_px,y_px,sxx_px2,sxy_px2,syy_px2\n"
        "\"a,\"\"b\"\".png\",0,1,300,200,0.1,0,0.1\n\"#c.png\",0,1,300,200,,,\n");
  const Outcome outcome = good_run("unproject " + path("seen.csv") + camera());
  EXPECT_HAS(outcome.err, "2 of 2 points");
  EXPECT_HAS(outcome.out, "\n\"a,\"\"b\"\".png\",0,1,300,200,");
  EXPECT_HAS(outcome.out, "\n\"#c.png\",0,1,300,200,");
}

// Of a column of the input all fields are numbers, or texts.
TEST_F(CliProject, NamesAreNoNumbersInJson) {
  spill(root() / "named.csv",
        "point,tag_id,batch,kind,x_m,y_m,z_m\n7,12,007,nan,0.10,0.05,.5\n"
        "007,-3,8,1,0,0,-1\n1e3,0,,2,0.1,0.05,0.5\n");
  const Outcome outcome = good_run("project " + path("named.csv") + camera() + " --json");
  for (const char* const part :
       {"\"point\": \"7\"", "\"point\": \"007\"", "\"point\": \"1e3\"", "\"tag_id\": 12",
        "\"tag_id\": -3", "\"batch\": \"007\"", "\"batch\": \"8\"", "\"batch\": null",
        "\"kind\": \"nan\"", "\"kind\": \"2\"", "\"x_m\": 0.1,", "\"z_m\": 0.5,", "\"valid\": 1"})
    EXPECT_HAS(outcome.out, part);
}

TEST_F(CliProject, WrongTablesAreNamed) {
  const auto project = [&](const std::string& text, const std::vector<std::string>& parts) {
    spill(root() / "bad.csv", text);
    expect_bad_input("project " + path("bad.csv") + camera(), parts);
  };
  project("", {"bad.csv: must begin with a line of column names"});
  project("x,y\n1,2\n", {"bad.csv: has the column \"x\" but not \"z\""});
  project("a,b\n1,2\n", {"bad.csv: must have the columns x_m,y_m,z_m"});
  project("x,y,z\n1,2\n", {"bad.csv: line 2: must have 3 fields"});
  project("x,y,z\n1,2,far\n", {"bad.csv: line 2: z: must be a finite number, got \"far\""});
  project("x,y,z,x\n1,2,3,4\n", {"\"x\" is there twice"});
  project("x,y,z,sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2\n1,2,3,-1,0,0,1,0,1\n",
          {"bad.csv: line 2: sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2: must be a covariance",
           "variances from 0 to 1e+100, got -1"});
  project("x,y,z\n\"1,2,3\n", {"bad.csv: line 2: the closing quote is missing"});
  project(std::string("x,y,z\0\n1,2,3\n", 13), {"bad.csv: line 1: is not text: binary data"});
  spill(root() / "bad.csv", "u_px,v_px,depth_m\n1,2,3\n");
  expect_bad_input("unproject " + path("bad.csv") + camera() + " --depth 2", {"--depth: excludes"});
  spill(root() / "sigma.csv", "u_px,v_px,depth_m,sigma_depth_m\n1,2,3,0\n1,2,3,-1\n");
  expect_bad_input("unproject " + path("sigma.csv") + camera(),
                   {"sigma.csv: line 3: sigma_depth_m: must be >= 0, got \"-1\""});
  expect_bad_input("unproject " + path("bad.csv") + camera() + " --plane",
                   {"--plane: needs --view"});
  expect_bad_input("unproject " + path("bad.csv") + camera() + " --view no", {"has no no"});
  expect_bad_input("project " + path("nothing.csv") + camera(), {"nothing.csv"});
}

}  // namespace
}  // namespace tagcal::tools
