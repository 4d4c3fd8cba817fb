#include <algorithm>
#include <map>
#include <set>

#include "summary.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal {
namespace {

// Findings that blame what may be right in a world. The first that matches decides.
struct Diagnosis {
  std::string_view name;
  FindingCode code;
  std::string_view true_with;  // names of the defects and of the mode in which it may be true
  std::string_view text = "";  // part of the sentence; empty: any sentence
  bool of_model = false;       // true where the answer's model does not contain the truth's lens
};
constexpr std::string_view kAnyDefect = "bend twist aspect rows";
constexpr Diagnosis kDiagnoses[] = {
    {"bent", code::board_bend_impossible, ""},
    {"bent", code::board_bent, "bend twist"},
    {"bent", code::flatness_exceeded, "bend twist"},
    {"target", code::tags_misplaced, "bend twist aspect"},
    {"target", code::tag_scale, "pixels"},  // ink spreads
    {"moved", code::view_rejected, "rows bend twist", "during the exposure"},
    {"view", code::board_moved, ""},
    {"view", code::view_rejected, "rows"},
    {"view", code::view_mirrored, ""},
    {"view", code::view_repeated, ""},
    {"consensus", code::no_consensus, "", "more than half"},
    {"noise", code::noise_understated, "pixels bend twist aspect rows"},
    {"model", code::model_too_small, "", "", true},
    {"model", code::other_lens, "", "", true},
    {"model", code::residuals_biased, kAnyDefect, "", true},
    {"model", code::halves_disagree, kAnyDefect, "", true}};

// True if the world has a defect, or the mode, for which the finding may be right.
bool may_be_true(const Diagnosis& diagnosis, const Record& record) {
  const auto has = [&](std::string_view name) {
    return record.mode == name || record.defects.find(name) != std::string::npos;
  };
  std::string_view rest = diagnosis.true_with;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (has(rest.substr(0, end))) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

// `finding` is "code: sentence" (record.hpp).
bool is_diagnosis(std::string_view finding, const Diagnosis& diagnosis) {
  const std::size_t end = std::min(finding.find(": "), finding.size());
  return finding.substr(0, end) == diagnosis.code.name &&
         finding.substr(end).find(diagnosis.text) != std::string_view::npos;
}

// True if every lens of model `other` is a lens of `model`.
bool contains(const std::string& model, const std::string& other) {
  static const std::map<std::string, std::set<std::string>> contained = {
      {"f", {"f"}},
      {"f+c", {"f", "f+c"}},
      {"pinhole", {"f", "f+c", "pinhole"}},
      {"radial1", {"f", "f+c", "radial1"}},
      {"radial2", {"f", "f+c", "radial1", "radial2"}},
      {"opencv4", {"f", "f+c", "pinhole", "radial1", "radial2", "opencv4"}},
      {"opencv5", {"f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5"}},
      {"opencv8", {"f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5", "opencv8"}},
      {"fisheye4", {"fisheye4"}}};
  const auto found = contained.find(model);
  return found != contained.end() && found->second.contains(other);
}

}  // namespace

std::vector<std::string_view> false_diagnoses(const Record& record) {
  std::vector<std::string_view> classes;
  std::string_view rest = record.findings;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(" | "), rest.size());
    const std::string_view finding = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 3, rest.size()));
    const auto* const found = std::ranges::find_if(
        kDiagnoses, [&](const Diagnosis& d) { return is_diagnosis(finding, d); });
    if (found == std::end(kDiagnoses) || may_be_true(*found, record)) continue;
    if (found->of_model && !contains(record.answer, record.model)) continue;
    if (std::ranges::find(classes, found->name) == classes.end()) classes.push_back(found->name);
  }
  return classes;
}

}  // namespace tagcal
