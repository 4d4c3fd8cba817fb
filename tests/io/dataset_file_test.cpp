#include "tagcal/io/dataset_file.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dataset_fixture.hpp"

namespace tagcal {
namespace {

TEST_F(DatasetFile, ReadsAllThatItNames) {
  const DatasetFolder read = read_dataset(folder_);
  EXPECT_EQ(read.dataset.image_size, (ImageSize{64, 48}));
  ASSERT_EQ(read.dataset.boards.size(), 1U);
  EXPECT_EQ(tags_of(read.dataset.boards[0].board).size(), 4U);
  EXPECT_EQ(read.observations.filename(), "seen.csv");
  ASSERT_EQ(read.dataset.views.size(), 2U);
  EXPECT_EQ(read.dataset.views[1].image, "b.png");
  EXPECT_EQ(read.dataset.views[1].observations.size(), 6U);
  EXPECT_EQ(read.dataset.views[0].observations[4].id, (CornerId{1, 0}));
  EXPECT_EQ(read.dataset.views[0].observations[4].pixel, Eigen::Vector2d(1.5, 2));
  EXPECT_EQ(read.images,
            (std::vector<fs::path>{folder_ / "images" / "a.png", folder_ / "images" / "b.png"}));
  ASSERT_TRUE(read.dataset.truth);
  EXPECT_EQ(read.dataset.truth->model, "opencv5");
  EXPECT_EQ(parameters(read.dataset.truth->camera.lens)[1], 61);
  EXPECT_EQ(read.dataset.truth->camera_from_world.at("a.png").translation().z(), 1);
  EXPECT_TRUE(read.warnings.empty());
}

TEST_F(DatasetFile, OnlyObservationsOrOnlyImages) {
  write("dataset.yaml", "image_size: [64, 48]\ntarget: target.yaml\nobservations: seen.csv\n");
  EXPECT_TRUE(read_dataset(folder_).images.empty());
  write("dataset.yaml", "image_size: [64, 48]\ntarget: target.yaml\nimages: images\n");
  const DatasetFolder read = read_dataset(folder_);
  EXPECT_TRUE(read.observations.empty());
  EXPECT_TRUE(read.dataset.views.empty());
  EXPECT_EQ(read.images.size(), 2U);
}

TEST_F(DatasetFile, SeveralBoards) {
  write("dataset.yaml",
        "image_size: [64, 48]\nimages: images\ntarget:\n  - target.yaml\n"
        "  - {file: target.yaml, first_id: 4, world_from_board: {translation_m: [1, 0, 0]}}\n");
  write("target.yaml", kTarget + "colour: red\n");
  const DatasetFolder read = read_dataset(folder_);
  ASSERT_EQ(read.dataset.boards.size(), 2U);
  EXPECT_EQ(tags_of(read.dataset.boards[1].board)[0].id, 4);
  EXPECT_EQ(read.dataset.boards[1].world_from_board.translation().x(), 1);
  EXPECT_EQ(read.warnings.size(), 2U);
}

// The ids of markers are no ids of corners; they count per dictionary.
TEST_F(DatasetFile, MarkersHaveIdsOfTheirOwn) {
  const std::string charuco =
      "target_type: charuco\nsquareCols: 3\nsquareRows: 3\nsquareSize: 0.04\n"
      "markerSize: 0.03\ndictionary: DICT_4X4_50\n";
  write("c.yaml", charuco);
  write("d.yaml", charuco + "first_id: 200\nfirst_marker_id: 4\n");
  write("e.yaml", charuco + "first_id: 300\nfirst_marker_id: 3\n");
  write("obs.csv", "image,tag_id,corner,x_px,y_px\na.png,203,0,1,2\n");
  const auto read = [&](const std::string& target) {
    write("dataset.yaml", "image_size: [64, 48]\nobservations: obs.csv\ntarget: " + target + "\n");
    return read_dataset(folder_);
  };
  EXPECT_EQ(read("[{file: c.yaml, first_id: 100}, d.yaml]").dataset.views.size(), 1U);
  EXPECT_HAS(error_of([&] { read("[c.yaml, d.yaml, e.yaml]"); }),
             "dataset.yaml: target: markers of DICT_4X4_50 must be unique over all "
             "boards, but marker 3 is on boards 0 and 2; give one of them another "
             "first_marker_id");
  write("obs.csv", "image,tag_id,corner,x_px,y_px\na.png,204,0,1,2\n");  // a marker's id
  EXPECT_HAS(error_of([&] { read("d.yaml"); }), "must be an id on the boards, got 204");
  write("obs.csv", "image,tag_id,corner,x_px,y_px\na.png,203,1,1,2\n");
  EXPECT_HAS(error_of([&] { read("d.yaml"); }), "corner: must be 0 for a point, got 1");
}

TEST_F(DatasetFile, BadDatasets) {
  fs::create_directory(folder_ / "empty");
  expect_bad(
      "dataset.yaml", kDataset,
      {{"[64, 48]", "[64, 0]", "dataset.yaml: image_size[1]: must be a whole number from 1 to"},
       {"[64, 48]", "[-64, 48]", "dataset.yaml: image_size[0]: must be a whole number from 1 to"},
       {"[64, 48]", "[64]", "dataset.yaml: image_size: must be a list of 2, got a list of 1"},
       {"[64, 48]", "64x48", "dataset.yaml: image_size: must be a list, got 64x48"},
       {"[64, 48]", "[48, 64]", "images/a.png: is 64x48 pixels, but image_size in dataset.yaml is"},
       {"image_size", "imagesize", "dataset.yaml: imagesize: unknown key; did you mean image_size"},
       {"image_size: [64, 48]\n", "", "dataset.yaml: image_size: the key is missing"},
       {"target: target.yaml\n", "", "dataset.yaml: target: the key is missing"},
       {"target.yaml", "none.yaml", "none.yaml: no such file"},
       {"target.yaml", "seen.csv", "seen.csv: is a table (CSV), not YAML"},
       {"target.yaml", "[]", "dataset.yaml: target: must be a list of at least 1, got a list of 0"},
       {"target.yaml", "[target.yaml, target.yaml]",
        "dataset.yaml: target: ids must be unique over all boards, but id 0 is on boards 0"},
       {"target.yaml", "[{file: target.yaml, first_id: -4}]",
        "dataset.yaml: target[0].first_id: must be a whole number from 0 to 2147483647, got -4"},
       {"target.yaml", "[{fil: target.yaml}]", "dataset.yaml: target[0].fil: unknown key; did you"},
       {"target.yaml", "[{first_id: 3}]", "dataset.yaml: target[0].file: the key is missing"},
       {"seen.csv", "none.csv", "none.csv: no such file"},
       {"seen.csv", "images", "images: is a folder, not a file"},
       {"images: images", "images: none", "dataset.yaml: images: must be a folder of pictures (No"},
       {"images: images", "images: empty", "dataset.yaml: images: must be a folder with pictures"},
       {"observations: seen.csv\nimages: images\n", "",
        "dataset.yaml: needs observations: FILE or"},
       {"truth.yaml", "none.yaml", "none.yaml: no such file"},
       {"[64, 48]\n", "[64, 48]\nimage_size: [64, 48]\n",
        "dataset.yaml: line 2: image_size: the"}});
  fs::remove(folder_ / "dataset.yaml");
  EXPECT_EQ(error(), "dataset.yaml: no such file");
  EXPECT_ERROR(
      read_dataset(folder_ / "none"),
      (folder_ / "none").string() + ": must be the folder of a data set, with dataset.yaml in it");
}

TEST_F(DatasetFile, BadTruths) {
  expect_bad(
      "truth.yaml", kTruth,
      {{"fx: 60", "fx: -60", "truth.yaml: camera.fx: must be > 0, got -60"},
       {"fx: 60", "fx: .nan", "truth.yaml: camera.fx: must be a finite number, got .nan"},
       {"  fx: 60\n", "", "truth.yaml: camera.fx: the key is missing"},
       {"opencv5", "opencv6", "truth.yaml: camera.model: must be one of f, f+c, pinhole, radial1"},
       {"opencv5", "weak", "truth.yaml: camera.model: must be one of f, f+c, pinhole, radial1"},
       {"opencv5", "radial1", "truth.yaml: camera: k2 must be 0 with model radial1, got"},
       {"opencv5", "fisheye4", "truth.yaml: camera: distortion: must have at most 4 coefficients"},
       {"[-0.1, 0.01, 0, 0, 0]", "[1, 2, 3, 4, 5, 6, 7, 8, 9]", "truth.yaml: camera.distortion: m"},
       {"image_width: 64", "image_width: 65", "truth.yaml: camera: is for 65x48 pixels, but image"},
       {"image: b.png", "image: a.png", "truth.yaml: poses[1].image: must differ from the images"},
       {"[0, 1, 0, 0]", "[0, 2, 0, 0]", "truth.yaml: poses[1].camera_from_world.rotation: must be"},
       {"camera_from_world:", "pose:", "truth.yaml: poses[0].pose: unknown key"},
       {"translation_m", "translation",
        "truth.yaml: poses[0].camera_from_world.translation: unk"}});
}

TEST_F(DatasetFile, TruthReadsBackToTheLastBit) {
  Random random(4);
  const double third = 1.0 / 3;
  const std::map<std::string, Lens> lenses = {
      {"f", pinhole(900 * third, 900 * third, 639.5, 399.5)},
      {"opencv5", Perspective({900 * third, 901, 640.1, 1e-300, -third, 0.1, 1e-5, -0.0, 0.7})},
      {"opencv8", Perspective({900, 901, 640, 400, third, 0, 0, 0, 0, -0.01, 1e-17, third})},
      {"fisheye4", Fisheye({300, 301, 640, 400, third / 9, -third / 99, 1e-9, -1e-12})}};
  for (const auto& [model, lens] : lenses) {
    Truth truth{{lens, {1280, 800}}, model, {}};
    for (int i = 0; i < 50; ++i) {
      truth.camera_from_world["\"quoted\" \\ " + std::to_string(i)] = pose_of_many_sizes(random);
    }
    write_truth(folder_ / "t.yaml", truth);
    const Truth back = read_truth(folder_ / "t.yaml");
    EXPECT_EQ(back.model, model);
    EXPECT_EQ(back.camera.image_size, truth.camera.image_size);
    ASSERT_EQ(back.camera.lens.index(), lens.index());
    const auto a = parameters(back.camera.lens), b = parameters(lens);
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << model;
    ASSERT_EQ(back.camera_from_world.size(), 50U);
    for (const auto& [image, pose] : truth.camera_from_world) {
      EXPECT_TRUE(same(back.camera_from_world.at(image), pose)) << image;
    }
    truth.model.clear();  // stands for the smallest one
    write_truth(folder_ / "t.yaml", truth);
    EXPECT_EQ(read_truth(folder_ / "t.yaml").model, model);
  }
}

TEST_F(DatasetFile, WrittenDatasetsReadBack) {
  Dataset dataset;
  dataset.image_size = {64, 48};
  dataset.boards = {{make_board(AprilGrid{2, 2, 0.1, 0.25, 0}), {}}};
  dataset.truth = read_truth(folder_ / "truth.yaml");
  const fs::path out = folder_ / "new" / "folder";
  write_dataset(out, dataset, "../../images", "");
  DatasetFolder back = read_dataset(out);
  EXPECT_EQ(back.images.size(), 2U);
  EXPECT_TRUE(back.observations.empty());
  EXPECT_EQ(back.dataset.truth->camera_from_world.size(), 2U);

  Random random(6);
  dataset.boards.push_back(
      {make_board(AprilGrid{2, 3, 0.1, 0.25, 10}), pose_of_many_sizes(random)});
  write_dataset(out, dataset, "", "../../seen.csv");
  back = read_dataset(out);
  EXPECT_FALSE(back.observations.empty());
  ASSERT_EQ(back.dataset.boards.size(), 2U);
  EXPECT_TRUE(same(back.dataset.boards[1].world_from_board, dataset.boards[1].world_from_board));
  EXPECT_EQ(tags_of(back.dataset.boards[1].board).back().id, 15);

  dataset.boards[1].board.substrate = {Material::glass, 3e-4};
  write_dataset(out, dataset, "", "../../seen.csv");
  back = read_dataset(out);
  EXPECT_EQ(back.dataset.boards[0].board.substrate, Substrate());
  EXPECT_EQ(back.dataset.boards[1].board.substrate, dataset.boards[1].board.substrate);
}

TEST_F(DatasetFile, DepthsStandBesideTheImages) {
  Dataset dataset;
  dataset.image_size = {64, 48};
  dataset.boards = {{make_board(AprilGrid{2, 2, 0.1, 0.25, 0}), {}}};
  const fs::path out = folder_ / "deep";
  write_dataset(out, dataset, "../images", "", DepthFolder{"depth", 0.0001});
  fs::create_directory(out / "depth");
  write_png(out / "depth/000.png", Image16({64, 48}));
  DatasetFolder back = read_dataset(out);
  EXPECT_EQ(back.depths, std::vector<fs::path>{out / "depth/000.png"});
  EXPECT_EQ(back.depth_unit_m, 0.0001);
  write_png(out / "depth/000.png", Image16({64, 47}));
  EXPECT_HAS(error_of([&] { read_dataset(out); }), "000.png: is 64x47 pixels, but image_size");
  const std::string text = read_text(out / "dataset.yaml");
  const auto error_with = [&](const std::string& depth) {
    std::ofstream(out / "dataset.yaml")
        << replaced(text, "{folder: \"depth\", unit_m: 0.0001}", depth);
    return error_of([&] { read_dataset(out); });
  };
  EXPECT_HAS(error_with("{folder: depth, unit_m: 0}"), "depth.unit_m: must be > 0, got 0");
  EXPECT_HAS(error_with("{folder: nowhere, unit_m: 1}"), "depth.folder: must be a folder");
  EXPECT_HAS(error_with("{folder: depth}"), "depth.unit_m: the key is missing");
}

RC_GTEST_FIXTURE_PROP(DatasetFile, MangledYamlEndsInAnErrorOrValidData, (std::uint64_t seed)) {
  Random random(seed);
  write("truth.yaml", mutated(kTruth, random));
  write("dataset.yaml", random.index(2) == 0 ? kDataset : mutated(kDataset, random));
  try {
    const DatasetFolder read = read_dataset(folder_);
    RC_ASSERT(read.dataset.image_size.width > 0 && !read.dataset.boards.empty());
    if (read.dataset.truth) {
      for (const double p : parameters(read.dataset.truth->camera.lens))
        RC_ASSERT(std::isfinite(p));
      for (const auto& [image, pose] : read.dataset.truth->camera_from_world) {
        RC_ASSERT(pose.matrix().allFinite());
      }
    }
  } catch (const Error& error) {
    RC_ASSERT(std::string(error.what()).find(folder_.string()) == 0U);
  }
}

}  // namespace
}  // namespace tagcal
