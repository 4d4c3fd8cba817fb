#include "job/find_corners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "job/corner_cache.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/progress.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

// The frames by which a frame was followed: with others its corners differ by what fits leave.
std::string names_between(const Input& input, std::size_t first, std::size_t end) {
  std::string names;
  for (std::size_t i = first; i < end; ++i) names += input.images[i].name + "\n";
  return names;
}

EarlierResults earlier_results(const Input& input, std::optional<CornerCache>& cache) {
  return {[&](std::size_t i, std::size_t first) {
            const std::string& name = input.images[i].name;
            return cache->find(name, input.files.at(name), names_between(input, first, i));
          },
          [&](std::size_t i, const DetectedPicture& found) {
            cache->keep(input.images[i].name, found);
          }};
}

void save(CornerCache& cache, Input& input, bool says_so) {
  cache.save();
  if (!cache.warning().empty()) input.warnings.push_back(cache.warning());
  if (!says_so) return;
  if (cache.num_reused() > 0) {
    print_note("corners of {} of {} pictures are those of {} (--no-cache: detect them again)\n",
               cache.num_reused(), input.images.size(), input.cache.string());
  }
}

void take_over(std::vector<DetectedPicture> found, std::vector<std::string> warnings,
               Input& input) {
  input.dataset.views.clear();
  input.unfitted.clear();
  std::vector<std::string> unreadable;
  for (DetectedPicture& picture : found) {
    input.corner_error_px = std::max(input.corner_error_px, picture.corner_error_px);
    unreadable.push_back(picture.unreadable);
    warnings.insert(warnings.end(), picture.warnings.begin(), picture.warnings.end());
    if (!picture.unreadable.empty()) continue;
    input.dataset.views.push_back(std::move(picture.view));
    input.unfitted.push_back(std::move(picture.unfitted));
  }
  leave_out_unreadable(input, unreadable);
  input.warnings.insert(input.warnings.end(), warnings.begin(), warnings.end());
}

}  // namespace

void check_detectable(const std::vector<PlacedBoard>& boards, const std::string& name) {
  if (std::all_of(boards.begin(), boards.end(),
                  [](const auto& b) { return point_kind(b.board) == PointKind::measured; })) {
    throw Error(fmt::format("{}: the target has no tags to detect, only points", name));
  }
  naming(name, [&] {
    for (const PlacedBoard& placed : boards) check_tags(placed.board);
  });
}

void detect_views(Input& input, int threads, bool shows_progress, const Camera* camera) {
  if (input.images.empty()) throw Error(fmt::format("{}: has no pictures", input.name));
  const auto& boards = input.dataset.boards;
  check_detectable(boards, input.name);
  DetectOptions options;
  options.threads = threads;
  options.refinement = input.refinement.value_or(options.refinement);
  options.camera = camera;
  options.skip_unreadable = !input.strict;
  std::optional<Progress> progress;
  if (shows_progress) progress.emplace("detecting", static_cast<int>(input.images.size()));
  std::optional<CornerCache> cache;
  if (!input.cache.empty()) cache.emplace(input.cache, boards, options);
  const EarlierResults earlier = earlier_results(input, cache);
  if (cache) options.earlier = &earlier;
  std::vector<DetectedPicture> found =
      detect_all(input.images, boards, options, [&](int done, int) {
        if (progress) progress->update(done);
      });
  progress.reset();
  if (cache) save(*cache, input, shows_progress);
  input.mistakes = target_mistakes(input.images, found, boards, options);
  std::vector<std::string> warnings = board_warnings(boards, input.mistakes);
  take_over(std::move(found), std::move(warnings), input);
}

void refine_views(Input& input, const Camera& camera, int threads, bool shows_progress) {
  if (input.images.empty()) throw Error(fmt::format("{}: has no pictures", input.name));
  std::optional<Progress> progress;
  if (shows_progress) progress.emplace("refining", static_cast<int>(input.dataset.views.size()));
  RefinedViews refined =
      refine_views(input.dataset, input.images, camera, threads, [&](int done, int) {
        if (progress) progress->update(done);
      });
  input.dataset.views = std::move(refined.views);
  input.corner_error_px = refined.corner_error_px;
  if (refined.num_refined_corners < refined.num_corners)
    input.warnings.push_back(fmt::format(
        "{} of {} corners of squares and centres of circles are not refined: the fit with the lens "
        "failed",
        refined.num_corners - refined.num_refined_corners, refined.num_corners));
  if (refined.num_refined_tags < refined.num_tags)
    input.warnings.push_back(
        fmt::format("the corners of {} of {} tags are not refined: the fit with the lens failed",
                    refined.num_tags - refined.num_refined_tags, refined.num_tags));
}

void find_views(Input& input, int threads, bool shows_progress, const Camera* camera) {
  if (input.observations.empty()) return detect_views(input, threads, shows_progress, camera);
  if (input.refinement)
    throw Error(fmt::format(
        "--refinement: belongs to corners found in pictures, those of {} are the ones of {}",
        input.name, input.observations));
  if (input.of_dataset && !input.images.empty())
    hold_note(
        fmt::format("{}: the corners are those of {}, as dataset.yaml says, and are not "
                    "found in the pictures",
                    input.name, input.observations));
}

void need_views(Input& input, int threads, bool shows_progress) {
  find_views(input, threads, shows_progress);
  const int corners = num_corners(input.dataset.views);
  if (corners < kFewestCorners) {
    throw Error(fmt::format("{}: must have {} corners or more in all, got {}",
                            input.observations.empty() ? input.name : input.observations,
                            kFewestCorners, corners));
  }
}

std::optional<Finding> wrong_target(const std::vector<TargetMistake>& mistakes) {
  const auto mistake = std::ranges::find_if(mistakes, &TargetMistake::moves_corners);
  if (mistake == mistakes.end()) return std::nullopt;
  return finding(code::no_consensus,
                 "the pictures and the target file do not agree: " + mistake->text());
}

int num_corners(const std::vector<View>& views) {
  std::size_t count = 0;
  for (const View& view : views) count += view.observations.size();
  return static_cast<int>(count);
}

int num_tags(const std::vector<View>& views) {
  std::size_t count = 0;
  for (const View& view : views) {
    std::set<int> ids;
    for (const Observation& seen : view.observations) ids.insert(seen.id.tag_id);
    count += ids.size();
  }
  return static_cast<int>(count);
}

bool has_tags(const std::vector<PlacedBoard>& boards) {
  return std::ranges::any_of(boards, [](const PlacedBoard& placed) {
    return point_kind(placed.board) == PointKind::tag_corner;
  });
}

}  // namespace tagcal::tools
