// Tests the claims of corners in real pictures: the error that the fits leave out
// (DetectedPicture::corner_error_px) is estimated from one half of the pictures, and the other half
// shows whether corners scatter as their claims with this error say. Of a single picture halves are
// the tags of every other place. Errors that are smooth over a board (lens, bend, rows) are no part
// of a corner's claim: what `calibrate` finds of them with these claims is its model_error_px.

#include <cmath>
#include <filesystem>
#include <memory>

#include "studies/studies.hpp"
#include "tagcal/detect/board_search/corner_error.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;

struct PictureFolder {
  std::string name;
  Board board;
  std::vector<Image8> images;
};

// One half, and what it shows.
struct Half {
  std::vector<PlacedBoard> boards;
  std::vector<View> views;
  ImageSize size;
  double error_px = 0;  // in the views' covariances
};

PictureFolder read_folder(const std::string& input, const std::string& target) {
  const fs::path path = fs::weakly_canonical(input);
  const bool is_folder = fs::is_directory(path);
  const fs::path own = (is_folder ? path : path.parent_path()) / "target.yaml";
  if (!fs::exists(own) && target.empty())
    throw Error(input + ": has no target.yaml beside it; name one with --target");
  PictureFolder folder{
      path.filename().string(), read_target(fs::exists(own) ? own : fs::path(target)), {}};
  for (const fs::path& file : is_folder ? list_pictures(path) : std::vector<fs::path>{path})
    folder.images.push_back(read_image(file));
  if (folder.images.empty()) throw Error(input + ": has no pictures");
  if (folder.images.size() == 1 && !tag_kind(folder.board))
    throw Error(input +
                ": one picture of a board without tags has no halves; give a folder of several");
  return folder;
}

Half detected(const std::vector<const Image8*>& images, const Board& board) {
  Half half{{{board, Pose()}}, {}, images.front()->size(), 0};
  std::vector<ImageSource> sources;
  for (std::size_t i = 0; i < images.size(); ++i)
    sources.push_back({std::to_string(i), [=] { return *images[i]; }});
  for (DetectedPicture& picture : detect_all(sources, half.boards, {.threads = 1})) {
    half.views.push_back(std::move(picture.view));
    half.error_px = picture.corner_error_px;
  }
  return half;
}

// The tags of every other place.
Board every_other_tag(const Board& board, std::size_t first) {
  const TagKind kind = *tag_kind(board);
  Tags tags{kind.family, kind.border_bits, {}};
  const std::vector<Tag> all = tags_of(board);
  for (std::size_t i = first; i < all.size(); i += 2) tags.tags.push_back(all[i]);
  return {tags};
}

std::vector<Half> halves_of(const PictureFolder& folder) {
  std::vector<Half> halves;
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}}) {
    std::vector<const Image8*> images;
    for (std::size_t i = first; i < folder.images.size(); i += 2)
      images.push_back(&folder.images[i]);
    halves.push_back(folder.images.size() > 1 ? detected(images, folder.board)
                                              : detected({&folder.images.front()},
                                                         every_other_tag(folder.board, first)));
  }
  return halves;
}

// Takes an error for the one that is in the covariances.
void replace_error(Half& half, double error_px) {
  for (View& view : half.views)
    for (Observation& seen : view.observations)
      if (seen.covariance_px2)
        seen.covariance_px2->diagonal().array() +=
            error_px * error_px - half.error_px * half.error_px;
  half.error_px = error_px;
}

internal::ScatterNees nees_of(Half& half) {
  std::vector<internal::ViewOfSize> views;
  for (View& view : half.views) views.push_back({&view, half.size});
  return internal::scatter_nees(views, half.boards);
}

Values row_of(Half half, double other_error_px) {
  replace_error(half, 0);
  double corners = 0, variance = 0;
  for (const View& view : half.views)
    for (const Observation& seen : view.observations)
      if (seen.covariance_px2) ++corners, variance += seen.covariance_px2->trace() / 2;
  const internal::ScatterNees alone = nees_of(half);
  replace_error(half, other_error_px);
  const internal::ScatterNees nees = nees_of(half);
  const Calibration calibration = calibrate({half.size, half.boards, half.views, {}});
  return {corners,
          variance,
          static_cast<double>(nees.num_corners),
          alone.sum,
          other_error_px,
          nees.sum,
          is_answer(calibration.status) ? calibration.model_error_px : std::nan(""),
          is_answer(calibration.status) ? calibration.model
                                        : std::string(status_name(calibration.status))};
}

std::vector<Values> measure(const PictureFolder& folder) {
  const std::vector<Half> halves = halves_of(folder);
  return {row_of(halves[1], halves[0].error_px), row_of(halves[0], halves[1].error_px)};
}

std::vector<Task> real_claims_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (const std::string& input : options.inputs) {
    const auto folder =
        std::make_shared<const PictureFolder>(read_folder(input, options.text("target")));
    tasks.push_back({folder->name, [=](std::uint64_t) { return measure(*folder); }, 1});
  }
  return tasks;
}

}  // namespace

Study real_claims_study() {
  return {
      .name = "real_claims",
      .summary = "claims of corners in real pictures, by halves",
      .inputs = "pictures, or folders of pictures, with a target.yaml beside or in them",
      .options = {{"target", "", "of those that have none"}},
      .columns = {"corners", "variance", "measured", "nees_alone", "corner_error_px", "nees",
                  "model_error_px", "model"},
      .tasks = real_claims_tasks,
      .tables = {{{"task"},
                  {sum_of("corners", "corners"),
                   root_ratio_of("claims of the fits, px", "variance", "corners", 4),
                   root_ratio_of("root NEES", "nees_alone", "measured", 2),
                   rms_of("corner_error_px of the other half", "corner_error_px", 4),
                   root_ratio_of("root NEES with it", "nees", "measured", 2),
                   rms_of("model_error_px", "model_error_px", 4), counts_of("models", "model")}}}};
}

}  // namespace tagcal
