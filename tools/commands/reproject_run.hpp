#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "job/reproject_targets.hpp"
#include "report/reproject_files.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// The arguments of `tagcal reproject`.
struct ReprojectArguments {
  std::string camera;
  std::vector<std::string> images;
  std::string out;
  ReprojectTask task;
  std::string target;  // of --plane
  std::string view;    // of --plane
  std::string interpolation = "bilinear";
  int border = 0;
  bool mask = false;
  bool maps = false;
  bool force = false;
  int threads = 0;
};

// Pictures that a camera took.
struct NewPictures {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;  // of the new pictures
};

// Throws Error if a picture has another size than the camera, which `camera_file` says.
NewPictures new_pictures(const std::vector<std::filesystem::path>& files, const Camera& camera,
                         const std::string& camera_file);

// Writes the picture `source` through `chain`, and what is seen of it unless `mask` is empty.
void write_reprojected(const std::filesystem::path& source, const Reprojection& chain,
                       const ReprojectArguments& arguments, int threads,
                       const std::filesystem::path& file, const std::filesystem::path& mask = {});

// One run of `tagcal reproject`: what it will write, and the writing.
class ReprojectRun {
 public:
  // All must outlive it. Throws Error if a picture has another size than the camera.
  ReprojectRun(const ReprojectArguments& arguments, const CalibrationFile& file);

  // Fills in targets, and the pictures that go through them.
  void plan();

  bool has_plan() const { return !targets_.empty(); }

  // Names of the files to be written, relative to the folder.
  std::vector<std::filesystem::path> files() const;

  void write(const std::filesystem::path& folder);

  void say_report() const;

 private:
  // One new picture of one picture.
  struct Job {
    std::size_t picture = 0;
    std::size_t target = 0;
    Pose camera_from_target;
  };

  void plan_plane();
  std::filesystem::path file_of(const Job& job) const;
  std::filesystem::path mask_of(const Job& job) const;
  // Each picture of a plane has its own mask; without pictures the plane has one.
  bool has_common_mask() const;
  void write_targets(const std::filesystem::path& folder);
  void write_target(const std::filesystem::path& folder, std::size_t t);
  Image8 seen_mask(const Reprojection& chain) const;
  void write_picture(const std::filesystem::path& folder, const Job& job, int threads) const;

  const ReprojectArguments& arguments_;
  const CalibrationFile& file_;
  const Camera& camera_;
  NewPictures pictures_;
  std::vector<ReprojectTarget> targets_;
  std::vector<NamedPoses> poses_;  // of each target
  std::vector<Job> jobs_;
  std::vector<double> shares_;  // of the pixels of each target that are seen; -1: not known
};

// `tagcal reproject LEFT RIGHT --camera RIG --rectify DIR`. Returns the exit code. Throws Error.
int run_rectify(const ReprojectArguments& arguments);

}  // namespace tagcal::tools
