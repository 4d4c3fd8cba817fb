#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/input.hpp"
#include "tagcal/estimate/findings.hpp"

// The corners of a command's pictures: found, or fitted again under a known lens.

namespace tagcal::tools {

// Throws Error, naming the target, if nothing on it can be detected, or a tag is not of its family.
void check_detectable(const std::vector<PlacedBoard>& boards, const std::string& name);

// Fills in the views by detection, with progress on stderr, and adds the detector's warnings. Tags
// are fitted with the lens of `camera` if it is given. Pictures that turn out to be damaged are
// left out as by read_input. Corners are taken from the cache where they are known. Throws Error
// without pictures, and for targets without tags.
void detect_views(Input& input, int threads, bool shows_progress = true,
                  const Camera* camera = nullptr);

// Fills in the views by detection if no observations were read.
void find_views(Input& input, int threads, bool shows_progress = true,
                const Camera* camera = nullptr);

constexpr int kFewestCorners = 12;  // in all, of a calibration

// The same; throws Error for fewer corners than that.
void need_views(Input& input, int threads, bool shows_progress = true);

// Fits the corners of the views in their pictures again, with a known lens. Tags that cannot be
// fitted keep their corners, and a warning gives their number. Throws Error without pictures.
void refine_views(Input& input, const Camera& camera, int threads, bool shows_progress = true);

// The refusal of any answer from these corners if a mistake moved them; else no value.
std::optional<Finding> wrong_target(const std::vector<TargetMistake>& mistakes);

// Puts that refusal, if there is one, before the findings of an answer, and sets the status.
template <typename Answer>
void refuse(const std::optional<Finding>& wrong, Answer& answer) {
  if (!wrong) return;
  answer.findings.insert(answer.findings.begin(), *wrong);
  answer.status = judge(answer.findings);
}

int num_corners(const std::vector<View>& views);
int num_tags(const std::vector<View>& views);

// True if a board has tags whose corners are observed.
bool has_tags(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::tools
