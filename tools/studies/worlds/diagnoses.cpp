#include <algorithm>
#include <map>
#include <set>

#include "summary.hpp"

namespace tagcal {
namespace {

// Sentences that blame what is right in every world. The first that fits decides.
struct Diagnosis {
  std::string_view name;
  std::string_view text;
  bool of_model = false;  // right where the answer's model does not hold the truth
};
constexpr Diagnosis kDiagnoses[] = {{"bent", "board bent by"},
                                    {"bent", "bent board better"},
                                    {"target", "the target is not as its file says"},
                                    {"moved", "moved during the exposure"},
                                    {"view", "do not hang where they should"},
                                    {"view", "its corners do not agree"},
                                    {"view", "its tags are mirrored"},
                                    {"view", "it repeats"},
                                    {"consensus", "agree with no common answer"},
                                    {"model", "the model is too small", true}};

// Whether a model can be every lens of the other.
bool holds(const std::string& model, const std::string& other) {
  static const std::map<std::string, std::set<std::string>> held = {
      {"f", {"f"}},
      {"f+c", {"f", "f+c"}},
      {"pinhole", {"f", "f+c", "pinhole"}},
      {"radial1", {"f", "f+c", "radial1"}},
      {"radial2", {"f", "f+c", "radial1", "radial2"}},
      {"opencv5", {"f", "f+c", "pinhole", "radial1", "radial2", "opencv5"}},
      {"opencv8", {"f", "f+c", "pinhole", "radial1", "radial2", "opencv5", "opencv8"}},
      {"fisheye4", {"fisheye4"}}};
  const auto found = held.find(model);
  return found != held.end() && found->second.contains(other);
}

}  // namespace

std::vector<std::string_view> false_diagnoses(const Record& record) {
  std::vector<std::string_view> classes;
  std::string_view rest = record.findings;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(" | "), rest.size());
    const std::string_view finding = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 3, rest.size()));
    const auto* const found = std::ranges::find_if(kDiagnoses, [&](const Diagnosis& d) {
      return finding.find(d.text) != std::string_view::npos;
    });
    if (found == std::end(kDiagnoses)) continue;
    if (found->of_model && !holds(record.answer, record.model)) continue;
    if (std::ranges::find(classes, found->name) == classes.end()) classes.push_back(found->name);
  }
  return classes;
}

}  // namespace tagcal
