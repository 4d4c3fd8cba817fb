// The CSV files of observations.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dataset_fixture.hpp"

namespace tagcal {
namespace {

using ObservationsFile = DatasetFile;

TEST_F(ObservationsFile, BadObservations) {
  expect_bad(
      "seen.csv", kSeen,
      {{"x_px,", "",
        "seen.csv: line 1: the header must be image,tag_id,corner,x_px,y_px, or image"},
       {"image,tag_id,corner,x_px,y_px\n", "",
        "seen.csv: line 1: the header must be image,tag_id,"},
       {"a.png,0,1,3,4", "a.png,0,1,3", "seen.csv: line 3: must have 5 fields, got 4"},
       {"a.png,0,1,3,4", "a.png,0,1,3,4,5", "seen.csv: line 3: must have 5 fields, got 6"},
       {"a.png,0,1,3,4", "a.png,0,1,3,4,5,6,7,8,9,",
        "seen.csv: line 3: must have 5 fields, got 11"},
       {"a.png,0,1,3,4", ",0,1,3,4",
        "seen.csv: line 3: image: must be the name of an image, got n"},
       {"a.png,0,1,3,4", "a.png,4,1,3,4",
        "seen.csv: line 3: tag_id: must be an id on the boards, g"},
       {"a.png,0,1,3,4", "a.png,-1,1,3,4",
        "seen.csv: line 3: tag_id: must be an id on the boards,"},
       {"a.png,0,1,3,4", "a.png,x,1,3,4",
        "seen.csv: line 3: tag_id: must be a whole number, got x"},
       {"a.png,0,1,3,4", "a.png,0.0,1,3,4",
        "seen.csv: line 3: tag_id: must be a whole number, got"},
       {"a.png,0,1,3,4", "a.png,0,4,3,4", "seen.csv: line 3: corner: must be from 0 to 3, got 4"},
       {"a.png,0,1,3,4", "a.png,0,-1,3,4", "seen.csv: line 3: corner: must be from 0 to 3, got -1"},
       {"a.png,0,1,3,4", "a.png,0,1,nan,4", "seen.csv: line 3: x_px: must be a finite number, got"},
       {"a.png,0,1,3,4", "a.png,0,1,3,inf", "seen.csv: line 3: y_px: must be a finite number, got"},
       {"a.png,0,1,3,4", "a.png,0,1,3,1e999",
        "seen.csv: line 3: y_px: must be a finite number, go"},
       {"a.png,0,1,3,4", "a.png,0,1,3,",
        "seen.csv: line 3: y_px: must be a finite number, got not"},
       {"a.png,0,1,3,4", "a.png,0,1,3 4,5", "seen.csv: line 3: x_px: must be a finite number, got"},
       {"a.png,0,1,3,4", "\"a.png,0,1,3,4", "seen.csv: line 3: the closing quote is missing"},
       {"a.png,0,1,3,4", "\"a\"b,0,1,3,4", "seen.csv: line 3: text after the closing quote"},
       {"a.png,0,1,3,4", "a.png,0,0,3,4",
        "seen.csv: line 3: corner 0 of tag 0 is given twice in ima"},
       {"b.png,1,1,2,2", "a.png,1,1,2,2",
        "seen.csv: line 13: corner 1 of tag 1 is given twice in im"},
       {"b.png,1,1,2,2", "a.png,0,0,2,2",
        "seen.csv: line 13: corner 0 of tag 0 is given twice in image a.png, first in line 2"}});
  write("seen.csv", "");
  EXPECT_EQ(error(), "seen.csv: is empty");
  write("seen.csv", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
  EXPECT_EQ(error(), "seen.csv: line 3: is not text: binary data");
}

TEST_F(ObservationsFile, BadCovariances) {
  const std::string good =
      "image,tag_id,corner,x_px,y_px,sxx_px2,sxy_px2,syy_px2\na,0,0,1,2,0.04,0.01,0.09\n";
  EXPECT_EQ((*read_csv(good)[0].observations[0].covariance_px2)(1, 0), 0.01);
  const std::vector<BadFile> table = {
      {"0.04", "0", "t.csv: line 2: sxx_px2: must be > 0, got 0"},
      {"0.09", "-1", "t.csv: line 2: syy_px2: must be > 0, got -1"},
      {"0.01", "0.06", "t.csv: line 2: sxy_px2: the covariance must be positive definite, got 0.0"},
      {"0.01", "-0.1", "t.csv: line 2: sxy_px2: the covariance must be positive definite, got -0."},
      {"0.01", "", "t.csv: line 2: sxy_px2: must be a finite number, got nothing"},
      {",0.09", "", "t.csv: line 2: must have 8 fields, got 7"},
      {"a,0,", "a,50,", "ok"},
      {"a,0,0", "a,50,1", "t.csv: line 2: corner: must be 0 for a point, got 1"}};
  for (const BadFile& bad : table) {
    if (bad.message == "ok") {
      EXPECT_NO_THROW(read_csv(replaced(good, bad.from, bad.to)));
      continue;
    }
    expect_line(csv_error(replaced(good, bad.from, bad.to)), bad.message);
  }
}

TEST_F(ObservationsFile, SpacesLineEndsQuotesAndInterleavedImages) {
  const std::vector<View> views = read_csv(
      "\xEF\xBB\xBFimage , tag_id,corner, x_px,y_px\r\n a , 0, 1,\t+1.5 , -2e1\r\n"
      "\"b, \"\"c\"\"\",0,1,1,1\r\n\r\na,0,2,.5,1.\r\n a,3,2,99999,1");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].image, "a");
  EXPECT_EQ(views[0].observations.size(), 3U);
  EXPECT_EQ(views[0].observations[0].pixel, Eigen::Vector2d(1.5, -20));
  EXPECT_EQ(views[0].observations[1].pixel, Eigen::Vector2d(0.5, 1));
  EXPECT_EQ(views[1].image, "b, \"c\"");
}

TEST_F(ObservationsFile, ObservationsReadBackToTheLastBit) {
  Random random(3);
  std::vector<View> views;
  for (const std::string image : {"x.png", "a,b \"c\".png", " y", "z \xc3\xa9"}) {
    View view{image, {}};
    for (int id = 0; id < 4; ++id) {
      for (int corner = 0; corner < 4; ++corner) {
        Observation o{{id, corner}, {random.normal() * 1e3, random.normal() * 1e-9}, {}};
        const double s = random.uniform(1e-3, 2), t = random.uniform(1e-3, 2);
        if (random.index(2) == 0) {
          o.covariance_px2 = (Matrix2() << s * s, 0.3 * s * t, 0.3 * s * t, t * t).finished();
        }
        view.observations.push_back(o);
      }
    }
    views.push_back(view);
  }
  const std::vector<View> back = read_csv(observations_csv(views));
  ASSERT_EQ(back.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(back[i].image, views[i].image);
    ASSERT_EQ(back[i].observations.size(), views[i].observations.size());
    for (std::size_t k = 0; k < back[i].observations.size(); ++k) {
      const Observation &a = back[i].observations[k], &b = views[i].observations[k];
      EXPECT_EQ(a.id, b.id);
      EXPECT_EQ(a.pixel, b.pixel);

      EXPECT_TRUE(a.covariance_px2 == b.covariance_px2);
    }
  }
  EXPECT_EQ(observations_csv({{"a", {{{1, 2}, {0.1, 3}, {}}}}}),
            "image,tag_id,corner,x_px,y_px\na,1,2,0.1,3\n");
  EXPECT_THROW(observations_csv({{"a\nb", {{{1, 2}, {0.1, 3}, {}}}}}), Error);
}

RC_GTEST_FIXTURE_PROP(ObservationsFile, MangledCsvEndsInAnErrorOrValidViews, (std::uint64_t seed)) {
  Random random(seed);
  for (int i = 0; i < 4; ++i) {
    const std::string text = mutated(kSeen, random);
    std::vector<View> views;
    try {
      views = read_csv(text);
    } catch (const Error& error) {
      RC_ASSERT(std::string(error.what()).find("t.csv: ") != std::string::npos);
      continue;
    }
    for (const View& view : views) {
      std::set<CornerId> ids;
      RC_ASSERT(!view.image.empty() && !view.observations.empty());
      for (const Observation& o : view.observations) {
        RC_ASSERT(o.pixel.allFinite() && ids.insert(o.id).second && o.id.corner <= 3);
      }
    }
  }
}

}  // namespace
}  // namespace tagcal
