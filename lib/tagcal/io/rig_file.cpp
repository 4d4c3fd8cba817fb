#include "tagcal/io/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/dataset/csv_rows.hpp"
#include "tagcal/io/dataset/dataset_parts.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/scene/rig_pairing.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

using LeaveOut = std::function<bool(const fs::path&)>;

constexpr const char* kTimesFile = "times.csv";

std::string file_name(const std::string& image) { return fs::path(image).filename().string(); }

ImageSize size_of_first(const std::vector<fs::path>& images, const YamlValue& camera) {
  for (const fs::path& image : images) {
    try {
      return read_image_size(image);
    } catch (const Error&) {
      continue;  // the next one, as check_image_sizes does
    }
  }
  camera.fail_plainly("needs image_size: [WIDTH, HEIGHT], because no picture states it");
}

// The pictures of a camera and their size.
void read_images(const fs::path& folder, const YamlValue& value, const LeaveOut& leave_out,
                 RigCameraFiles& files, Dataset& data) {
  if (const auto images = value.find("images")) {
    files.images = list_dataset_images(folder / images->text(), *images);
    if (leave_out) std::erase_if(files.images, leave_out);
  }
  const auto size = value.find("image_size");
  data.image_size = size ? read_image_size_value(*size) : size_of_first(files.images, value);
  const std::string stated =
      size ? fmt::format("{}.image_size in dataset.yaml", value.path()) : "the first picture";
  files.unreadable = check_image_sizes(files.images, data.image_size, stated);
}

RigCamera read_rig_dataset_camera(const fs::path& folder, const YamlValue& value,
                                  const std::vector<PlacedBoard>& boards, const LeaveOut& leave_out,
                                  RigFolder& read) {
  value.allow_only({"name", "image_size", "images", "observations", "times", "truth"});
  RigCamera camera{value.at("name").text(), {{}, boards, {}, {}}, {}};
  RigCameraFiles files;
  const auto observations = value.find("observations");
  if (!observations && !value.find("images"))
    value.fail_plainly("needs observations: FILE or images: FOLDER");
  if (observations) {
    files.observations = folder / observations->text();
    read.texts.push_back(files.observations);
    camera.data.views = read_observations(files.observations, boards, &read.warnings);
  }
  read_images(folder, value, leave_out, files, camera.data);
  if (const auto times = value.find("times")) {
    files.times = folder / times->text();
    read.texts.push_back(files.times);
    files.times_s = read_picture_times(files.times);
    camera.times_s = times_of(camera.data.views, files);
  }
  if (const auto truth = value.find("truth")) {
    read.texts.push_back(folder / truth->text());
    camera.data.truth = read_truth(read.texts.back());
    check_truth_size(*camera.data.truth, read.texts.back(), camera.data.image_size);
  }
  read.files.push_back(std::move(files));
  return camera;
}

// Throws if two cameras have one name, or the same pictures or observations.
void check_distinct(const fs::path& folder, const std::vector<YamlValue>& cameras) {
  for (const char* key : {"name", "images", "observations"}) {
    std::set<std::string> before;
    for (const YamlValue& camera : cameras) {
      const auto value = camera.find(key);
      if (!value) continue;
      const bool is_name = std::string_view(key) == "name";
      std::error_code unreadable;  // an error of its own, later
      const std::string text =
          is_name ? value->text()
                  : fs::weakly_canonical(folder / value->text(), unreadable).string();
      if (!before.insert(text).second) value->fail("must differ from the cameras before it");
    }
  }
}

std::string camera_lines(const RigCamera& camera, const RigFileNames& names) {
  const ImageSize& size = camera.data.image_size;
  std::string text = fmt::format("    - name: {}\n      image_size: [{}, {}]\n",
                                 text_yaml(camera.name), size.width, size.height);
  const auto add = [&](const char* key, const std::string& name) {
    if (!name.empty())
      text += fmt::format("      {}: {}\n", key, text_yaml(camera.name + "/" + name));
  };
  add("images", names.images);
  add("observations", names.observations);
  if (!camera.times_s.empty()) add("times", kTimesFile);
  if (camera.data.truth) add("truth", names.truth);
  return text;
}

std::string times_csv(const RigCamera& camera) {
  std::string text = "image,time_s\n";
  for (std::size_t i = 0; i < camera.times_s.size(); ++i)
    text += fmt::format("{},{}\n", image_field(camera.data.views[i].image), camera.times_s[i]);
  return text;
}

std::string rig_truth_yaml(const RigDataset& rig) {
  std::string text = "cameras:\n";
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    text += fmt::format("  - name: {}\n    camera_from_rig: {}\n    time_offset_s: {}\n",
                        text_yaml(rig.cameras[c].name), pose_yaml(rig.truth->camera_from_rig[c]),
                        rig.truth->time_offset_s[c]);
  return text;
}

}  // namespace

std::map<std::string, double> read_picture_times(const fs::path& file) {
  const CsvRows rows(file);
  if (rows.header() != std::vector<std::string>{"image", "time_s"})
    throw Error(file.string() + ": line 1: must be the header image,time_s");
  std::map<std::string, double> times_s;
  for (const CsvRow& row : rows.rows()) {
    const auto time_s = parse_number(row.fields[1]);
    if (!time_s)
      rows.fail(row, fmt::format("time_s: must be a finite number, got {}", shown(row.fields[1])));
    if (!times_s.emplace(file_name(row.fields[0]), *time_s).second)
      rows.fail(row, fmt::format("image: {} has a time already", shown(row.fields[0])));
  }
  return times_s;
}

RigFolder read_rig_folder(const fs::path& folder, const LeaveOut& leave_out) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw Error(folder.string() + ": must be the folder of a data set, with dataset.yaml in it");
  const YamlValue top = YamlValue::read(folder / "dataset.yaml");
  top.allow_only({"target", "rig", "truth"});
  RigFolder read;
  TargetFiles targets;
  const auto boards = read_dataset_boards(top.at("target"), targets, &read.warnings);
  read.texts = targets.names();
  read.texts.push_back(folder / "dataset.yaml");
  const YamlValue value = top.at("rig");
  value.allow_only({"cameras"});
  const auto cameras = value.at("cameras").items(1, limits::kMaxRigCameras);
  check_distinct(folder, cameras);
  RigDataset& rig = read.rig;
  for (const YamlValue& camera : cameras)
    rig.cameras.push_back(read_rig_dataset_camera(folder, camera, boards, leave_out, read));
  if (const auto truth = top.find("truth")) {
    read.texts.push_back(folder / truth->text());
    rig.truth = read_rig_truth(read.texts.back(), rig.cameras);
  }
  if (std::ranges::none_of(read.files, &fs::path::empty, &RigCameraFiles::observations))
    rig.instants = pair_by_name(rig.cameras);
  return read;
}

RigDataset read_rig_dataset(const fs::path& folder) { return read_rig_folder(folder).rig; }

bool is_rig_folder(const fs::path& folder) {
  try {
    return YamlValue::read(folder / "dataset.yaml").find("rig").has_value();
  } catch (const Error&) {
    return false;
  }
}

std::vector<double> times_of(const std::vector<View>& views, const RigCameraFiles& files) {
  std::vector<double> times_s;
  for (const View& view : views) {
    const auto found = files.times_s.find(file_name(view.image));
    if (found == files.times_s.end())
      throw Error(fmt::format("{}: has no row for the picture {}", files.times.string(),
                              shown(view.image)));
    times_s.push_back(found->second);
  }
  return times_s;
}

RigTruth read_rig_truth(const fs::path& file, const std::vector<RigCamera>& cameras) {
  const YamlValue top = YamlValue::read(file);
  top.allow_only({"cameras"});
  const YamlValue list = top.at("cameras");
  RigTruth truth;
  for (const YamlValue& item : list.items(1, limits::kMaxRigCameras)) {
    item.allow_only({"name", "camera_from_rig", "time_offset_s"});
    const std::size_t c = truth.camera_from_rig.size();
    if (c >= cameras.size() || item.at("name").text() != cameras[c].name)
      item.at("name").fail("must be the cameras of dataset.yaml in their order");
    truth.camera_from_rig.push_back(read_pose(item.at("camera_from_rig")));
    const auto offset = item.find("time_offset_s");
    truth.time_offset_s.push_back(offset ? offset->number() : 0);
  }
  if (truth.camera_from_rig.size() < cameras.size())
    list.fail_plainly(fmt::format("has {} cameras, but dataset.yaml has {}",
                                  truth.camera_from_rig.size(), cameras.size()));
  return truth;
}

std::vector<std::string> cameras_of_rig_truth(const fs::path& file) {
  const auto cameras = YamlValue::read(file).find("cameras");
  std::vector<std::string> names;
  if (cameras)
    for (const YamlValue& item : cameras->items(1, limits::kMaxRigCameras))
      names.push_back(item.at("name").text());
  return names;
}

void write_rig_dataset(const fs::path& folder, const RigDataset& rig, const RigFileNames& names) {
  std::string text = write_dataset_boards(folder, rig.cameras.front().data.boards);
  text += "rig:\n  cameras:\n";
  for (const RigCamera& camera : rig.cameras) {
    text += camera_lines(camera, names);
    if (!camera.times_s.empty()) write_whole(folder / camera.name / kTimesFile, times_csv(camera));
  }
  if (rig.truth) {
    write_whole(folder / "truth.yaml", rig_truth_yaml(rig));
    text += "truth: truth.yaml\n";
  }
  write_whole(folder / "dataset.yaml", text);
}

}  // namespace tagcal
