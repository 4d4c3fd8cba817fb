// tagcal board from outside: every kind of board, on every kind of page.
#include <opencv2/calib3d.hpp>

#include <tuple>

#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal::tools {
namespace {

const std::map<std::string, std::string> kBoards = {
    {"grid", "target_type: aprilgrid\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n"},
    {"checker",
     "target_type: checkerboard\ntargetCols: 8\ntargetRows: 5\nrowSpacingMeters: 0.03\n"
     "colSpacingMeters: 0.03\n"},
    {"charuco",
     "target_type: charuco\nsquareCols: 7\nsquareRows: 5\nsquareSize: 0.035\nmarkerSize: 0.026\n"
     "dictionary: DICT_5X5_100\n"},
    {"circles",
     "target_type: circlegrid\ntargetCols: 4\ntargetRows: 11\nspacingMeters: 0.02\n"
     "asymmetricGrid: true\ndiameterMeters: 0.015\n"},
    {"tags",
     "target_type: tags\ntags:\n  - {id: 3, size: 0.1, pose: {}}\n"
     "  - {id: 4, size: 0.05, pose: {translation_m: [0.2, 0, 0]}}\n"}};

class CliBoard : public Cli {
 protected:
  static std::string target(const std::string& name) {
    spill(root() / (name + ".yaml"), kBoards.at(name));
    return path(name + ".yaml");
  }
};

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// The size that --paper picks, in metres.
double leading_size(const Board& board) {
  if (const auto* const circles = std::get_if<CircleGrid>(&board.pattern)) return circles->spacing;
  const auto squares = checkers(board);
  return squares ? squares->column_spacing : tags_of(board)[0].size;
}

// The black box of a picture above the scale bar, in pixels: left, right and top border.
struct InkBox {
  int left = 1 << 30, right = -1, top = 1 << 30;
};
InkBox ink_box(const Image8& picture) {
  InkBox box;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      if (picture(x, y) < 128) {
        box.left = std::min(box.left, x);
        box.right = std::max(box.right, x);
        box.top = std::min(box.top, y);
      }
  return box;
}

TEST_F(CliBoard, PaperPicksTheLargestBoardAndWritesItsTarget) {
  for (const auto& [name, text] : kBoards) {
    const std::string yaml = target(name);
    double last = 0;
    for (const auto& [paper, width, height] :
         {std::tuple("letter", 215.9, 279.4), {"a4", 210, 297}, {"a3", 297, 420}}) {
      SCOPED_TRACE(name + " " + paper);
      const std::string png = path(name + "-" + paper + ".png");
      const Outcome made =
          good_run("board " + yaml + " --dpi 50.8 --paper " + paper + " --out " + png);
      EXPECT_HAS(made.err, name + "-" + paper + ".yaml: the target to use");
      const Board board = read_target(root() / (name + "-" + paper + ".yaml"));
      const double half_mm = leading_size(board) * 2000;
      EXPECT_NEAR(half_mm, std::round(half_mm), 1e-9);
      EXPECT_TRUE(paper != std::string("a3") || leading_size(board) > last);
      last = leading_size(board);
      // Two pixels a millimetre: the page is the paper, and 10 mm at its border stay white.
      const Image8 picture = read_image(png);
      const bool lying = picture.width() > picture.height();
      EXPECT_NEAR(picture.width(), 2 * (lying ? height : width), 1.01);
      EXPECT_NEAR(picture.height(), 2 * (lying ? width : height), 1.01);
      const InkBox box = ink_box(picture);
      EXPECT_GE(box.left, 19);
      EXPECT_LE(box.right, picture.width() - 19);
      EXPECT_GE(box.top, 19);
    }
  }
  const std::vector<Tag> tags = tags_of(read_target(root() / "tags-a4.yaml"));
  EXPECT_NEAR(tags[1].size, tags[0].size / 2, 1e-12);
  EXPECT_NEAR(tags[1].board_from_tag.translation().x(), 2 * tags[0].size, 1e-12);
  const auto charuco = std::get<Charuco>(read_target(root() / "charuco-a4.yaml").pattern);
  EXPECT_NEAR(charuco.marker_size / charuco.square_size, 26.0 / 35, 0.02);
  const double landscape = leading_size(read_target(root() / "grid-a4.yaml"));
  good_run("board " + target("grid") + " --paper a4 --landscape --out " + path("l.svg"));
  EXPECT_LT(leading_size(read_target(root() / "l.yaml")), landscape);
  EXPECT_HAS(slurp(root() / "l.svg"), "width=\"297.0000mm\"");
}

TEST_F(CliBoard, PdfsAreTrueToScale) {
  for (const auto& [name, text] : kBoards) {
    good_run("board " + target(name) + " --paper a4 --out " + path(name + "-4.pdf"));
    const std::string text_of_pdf = slurp(root() / (name + "-4.pdf"));
    EXPECT_TRUE(text_of_pdf.starts_with("%PDF-"));
    const bool portrait = text_of_pdf.find("/MediaBox [ 0 0 595.27") != std::string::npos;
    EXPECT_TRUE(portrait || text_of_pdf.find("/MediaBox [ 0 0 841.8") != std::string::npos);
    // Equal boards give equal bytes.
    ASSERT_EQ(run("board " + target(name) + " --out " + path("x.pdf")).exit_code, 0);
    const std::string first = slurp(root() / "x.pdf");
    ASSERT_EQ(run("board " + target(name) + " --out " + path("x.pdf")).exit_code, 0);
    EXPECT_EQ(slurp(root() / "x.pdf"), first);
  }
}

TEST_F(CliBoard, TilesCoverTheBoard) {
  const Outcome made =
      good_run("board " + target("grid") + " --tile a4 --out " + path("tiles.pdf"));
  // 748 x 776 mm on pages that each add 176 x 263 mm.
  EXPECT_HAS(made.err, "15 pages of a4");
  EXPECT_EQ(count(slurp(root() / "tiles.pdf"), "/MediaBox"), 15U);
  EXPECT_HAS(run("board " + target("tags") + " --tile a3 --out " + path("tiles.pdf")).err,
             "in 1 page of a3");
}

// The squares of a printed checkerboard, as OpenCV finds them.
TEST_F(CliBoard, SquaresAreTrueToScale) {
  const std::string png = path("squares.png");
  const Outcome made = good_run("board " + target("checker") + " --dpi 127 --out " + png);
  EXPECT_HAS(made.err, "9 x 6 squares of 30 mm on 300 x 235 mm, fits a3");
  const Image8 picture = read_image(png);
  const cv::Mat mat(picture.height(), picture.width(), CV_8U,
                    const_cast<std::uint8_t*>(picture.row(0)));
  std::vector<cv::Point2f> corners;
  ASSERT_TRUE(cv::findChessboardCornersSB(mat, {8, 5}, corners, 0));
  const auto [left, right] = std::ranges::minmax(corners, {}, &cv::Point2f::x);
  const auto [top, bottom] = std::ranges::minmax(corners, {}, &cv::Point2f::y);
  EXPECT_NEAR(right.x - left.x, 7 * 30 * 5, 0.2);
  EXPECT_NEAR(bottom.y - top.y, 4 * 30 * 5, 0.2);
  // 15 mm of margin, one square, five pixels a millimetre.
  EXPECT_NEAR(left.x, (15 + 30) * 5 - 0.5, 0.2);
  EXPECT_NEAR(top.y, (15 + 30) * 5 - 0.5, 0.2);
}

TEST_F(CliBoard, NamesOfFilesMayBeAnything) {
  target("checker");
  for (const std::string name : {"b\xE4r<&>.yaml", "\xC3\x9C ber.yaml"}) {
    fs::copy_file(root() / "checker.yaml", root() / name, fs::copy_options::overwrite_existing);
    for (const std::string out : {"named.pdf", "named.svg", "named.png --dpi 50"}) {
      good_run("board '" + path(name) + "' --out " + path(out));
    }
    const std::string svg = slurp(root() / "named.svg");
    const bool utf8 = name.starts_with("\xC3");
    EXPECT_HAS(svg,
               utf8 ? "<title>\xC3\x9C ber.yaml<" : "<title>b\xEF\xBF\xBDr&lt;&amp;&gt;.yaml<");
  }
}

TEST_F(CliBoard, WarnsWherePaperIsTooSmall) {
  const Outcome large = good_run("board " + target("grid") + " --out " + path("large.svg"));
  EXPECT_HAS(large.err, "warning: 748 x 776 mm fit on no common paper");
  const std::string svg = slurp(root() / "large.svg");
  EXPECT_HAS(svg, "width=\"748.0000mm\"");
}

TEST_F(CliBoard, WhatPaperOrPixelsCannotShowIsRefused) {
  const std::string grid = target("grid"), png = path("coarse.png");
  for (const std::string dpi : {"1", "1e-300"})
    expect_bad_input("board " + grid + " --dpi " + dpi + " --out " + png,
                     {"--dpi: must be ", "2 pixels for each cell", "got " + dpi});
  EXPECT_FALSE(fs::exists(png));
  const std::string list = "target_type: tags\nfamily: tag36h11\ntags:\n  - {id: 3, size: ";
  spill(root() / "tiny.yaml", list + "1.0e-300, pose: {}}\n");
  expect_bad_input("board " + path("tiny.yaml") + " --out " + path("tiny.pdf"),
                   {"tiny.yaml: the smallest cells must be 0.01 mm wide"});
  const std::string two = list + "0.1, pose: {}}\n  - {id: 1, size: 0.1, pose: {translation_m: [";
  for (const auto& [x, covers] : {std::pair("0.01", true), {"0.1", false}, {"-0.099", true}}) {
    spill(root() / "two.yaml", two + x + ", 0, 0]}}\n");
    const Outcome made = good_run("board " + path("two.yaml") + " --out " + path("two.pdf"));
    EXPECT_EQ(made.err.find("two.yaml: tags 1 and 3 cover each other") != std::string::npos, covers)
        << made.err;
  }
}

TEST_F(CliBoard, PaperReplacesNoFileThatIsNoTarget) {
  spill(path("precious.yaml"), "precious: 1\n");
  expect_bad_input("board " + target("grid") + " --paper a4 --out " + path("precious.pdf"),
                   {"precious.yaml", "another file"});
  EXPECT_EQ(slurp(path("precious.yaml")), "precious: 1\n");
  fs::remove(path("precious.yaml"));
}

TEST_F(CliBoard, BadInput) {
  const std::string grid = target("grid");
  const auto before = names();
  expect_bad_input("board " + grid + " --paper a4 --out " + path("grid.pdf"),
                   {"grid.yaml", "the one to be read"});
  expect_bad_input("board " + grid + " --tile a4 --out " + path("n.png"), {"--tile", ".pdf"});
  expect_bad_input("board " + grid + " --tile a4 --paper a4 --out " + path("n.pdf"),
                   {"--tile", "--paper"});
  expect_bad_input("board " + grid + " --paper a5 --out " + path("n.pdf"), {"--paper", "a5"});
  expect_bad_input("board " + grid + " --landscape --out " + path("n.pdf"),
                   {"--landscape", "--paper"});
  EXPECT_EQ(names(), before);
  spill(root() / "points.yaml", "target_type: points\npoints: [[1, 0, 0, 0]]\n");
  expect_bad_input("board " + path("points.yaml") + " --out " + path("n.pdf"),
                   {"points.yaml", "only points"});
  spill(root() / "many.yaml",
        "target_type: checkerboard\ntargetCols: 900\ntargetRows: 5\nrowSpacingMeters: 1\n"
        "colSpacingMeters: 1\n");
  expect_bad_input("board " + path("many.yaml") + " --paper a4 --out " + path("n.pdf"),
                   {"--paper", "a4", "too small"});
  spill(root() / "odd.yaml", replaced(kBoards.at("charuco"), "DICT_5X5_100", "DICT_5X5_99"));
  expect_bad_input("board " + path("odd.yaml") + " --out " + path("n.pdf"), {"DICT_5X5_99"});
  spill(root() / "few.yaml",
        replaced(kBoards.at("charuco"), "DICT_5X5_100", "DICT_5X5_50\nfirst_marker_id: 40"));
  expect_bad_input("board " + path("few.yaml") + " --out " + path("n.pdf"), {"50", "DICT_5X5_50"});
}

}  // namespace
}  // namespace tagcal::tools
