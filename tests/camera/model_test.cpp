#include <gtest/gtest.h>

#include "expect.hpp"
#include "tagcal/camera/model.hpp"

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

TEST(Model, ContainsTheCamerasOfItsFreeParameters) {
  const ImageSize size{640, 480};
  const auto smallest = [&](const Lens& lens) {
    for (const Model& model : Model::all())
      if (model.contains({lens, size})) return std::string(model.name());
    return std::string("none");
  };
  EXPECT_EQ(smallest(pinhole(600, 600, 319.5, 239.5)), "f");
  EXPECT_EQ(smallest(pinhole(600, 600, 320, 239.5)), "f+c");
  EXPECT_EQ(smallest(pinhole(600, 601, 320, 239.5)), "pinhole");
  EXPECT_EQ(smallest(Perspective({600, 600, 320, 240, 0.1})), "radial1");
  EXPECT_EQ(smallest(Perspective({600, 600, 320, 240, 0.1, 0, 0, 0, 0, 0, 0, 1e-9})), "opencv8");
  EXPECT_EQ(smallest(Fisheye({300, 300, 320, 240, 0.1})), "fisheye4");
  EXPECT_EQ(smallest(Parallel({500, 500, 319.5, 239.5, 0.3, 0})), "none");
}

TEST(Model, WhatIsNoLensHasNoValue) {
  EXPECT_FALSE(Model::named("f").lens(std::vector<double>{-1}, {640, 480}).has_value());
  EXPECT_FALSE(Model::named("f").lens(std::vector<double>{std::nan("")}, {640, 480}).has_value());
}

TEST(Model, HeldParametersAreNotFree) {
  const HeldModels models({{"cx", 300}, {"k3", 0.1}}, kind_of<Perspective>());
  const Model& model = models.named("opencv5");
  EXPECT_EQ(model.num_free(), 7);
  const auto lens = model.lens(model.free_values(pinhole(500, 510, 1, 2)), {640, 480});
  ASSERT_TRUE(lens.has_value());
  const auto p = parameters(*lens);
  EXPECT_EQ(std::vector<double>(p.begin(), p.begin() + 4), (std::vector<double>{500, 510, 300, 2}));
  EXPECT_EQ(p[8], 0.1);
  EXPECT_EQ(&model.sibling("opencv5"), &model);
  EXPECT_EQ(model.sibling("f").held().at(2), 300);
  EXPECT_FALSE(model.sibling("fisheye4").held().contains(8));  // its coefficients are others
  EXPECT_TRUE(Model::named("f").sibling("opencv5").held().empty());
}

TEST(Model, SquarePixelsStaySquare) {
  const HeldModels models({{"fx", 500}}, kind_of<Perspective>());
  const Model& square = models.named("radial1");
  const auto lens = square.lens(std::vector<double>{320, 240, 0}, {640, 480});
  ASSERT_TRUE(lens.has_value());
  const auto p = parameters(*lens);
  EXPECT_EQ(p[0], 500);
  EXPECT_EQ(p[1], 500);
  EXPECT_EQ(models.named("opencv5").free().front().name, "fy");
}

TEST(Model, TheHeldLadderHasNothingEmptyAndNothingTwice) {
  const HeldModels centre({{"cx", 320}, {"cy", 240}}, kind_of<Perspective>());
  std::vector<std::string_view> names;
  for (const Model* model : centre.all()) names.push_back(model->name());
  EXPECT_EQ(names,
            (std::vector<std::string_view>{"weak", "f", "pinhole", "radial1", "radial2", "ds",
                                           "eucm", "opencv4", "fisheye4", "opencv5", "opencv8"}));
  const HeldModels focal({{"f", 500}}, kind_of<Perspective>());
  EXPECT_EQ(focal.named("f").name(), "f+c");  // nothing is free in f itself
  EXPECT_EQ(focal.all().front()->name(), "weak");
}

TEST(Model, UnknownNameIsAnErrorThatListsTheKnownOnes) {
  const std::string error = error_of([] { Model::named("opencv55"); });
  EXPECT_HAS(error, "opencv5, ");
  EXPECT_HAS(error, "opencv55");
}

}  // namespace
}  // namespace tagcal
