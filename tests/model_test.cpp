#include <gtest/gtest.h>

#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

TEST(Model, LadderGrowsInParameters) {
  int last = -1;
  for (const Model& model : Model::all()) {
    EXPECT_GE(model.num_free(), last) << model.name();
    last = model.num_free();
    EXPECT_EQ(&Model::named(model.name()), &model);
  }
}

TEST(Model, SquarePixelsAndAHeldCentre) {
  const std::vector<double> values = {900};
  const auto lens = Model::named("f").lens(values, {1280, 800});
  ASSERT_TRUE(lens.has_value());
  const auto p = parameters(*lens);
  EXPECT_EQ(std::vector<double>(p.begin(), p.begin() + 5),
            (std::vector<double>{900, 900, 639.5, 399.5, 0}));
}

TEST(Model, FreeValuesInvertLens) {
  for (const Model& model : Model::all()) {
    std::vector<double> values;
    for (int i = 0; i < model.num_free(); ++i) values.push_back(0.01 * (i + 1));
    const auto lens = model.lens(values, {640, 480});
    ASSERT_TRUE(lens.has_value()) << model.name();
    EXPECT_EQ(model.free_values(*lens), values) << model.name();
  }
}

TEST(Model, WhatIsNoLensHasNoValue) {
  EXPECT_FALSE(Model::named("f").lens(std::vector<double>{-1}, {640, 480}).has_value());
  EXPECT_FALSE(Model::named("f").lens(std::vector<double>{std::nan("")}, {640, 480}).has_value());
}

TEST(Model, UnknownNameIsAnErrorThatListsTheKnownOnes) {
  try {
    Model::named("opencv55");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("opencv5, "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("opencv55"), std::string::npos);
  }
}

}  // namespace
}  // namespace tagcal
