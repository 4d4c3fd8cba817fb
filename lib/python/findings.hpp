#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::python {

// The text of an estimate without an answer: its status and the sentence of its refusal.
std::string refusal(Status status, const std::vector<Finding>& findings);

// "; 2 warnings", or nothing.
std::string warnings_text(const std::vector<Finding>& findings);

// Defines for an answer `is_answer`, the text of a file (`yaml`, of a const T&; `doc`: of which)
// and a representation (`text`, of a const T&).
template <typename T, typename Yaml, typename Text>
void define_file_answer(Record<T>& record, const Yaml& yaml, const char* doc, const Text& text) {
  record.def_property_readonly(
      "is_answer", [](const T& answer) { return is_answer(answer.status); },
      "True if the status is \"ok\".");
  record.def(
      "to_yaml",
      [yaml, text](const T& answer) {
        if (!is_answer(answer.status)) throw Error("to_yaml: there is no answer: " + text(answer));
        return yaml(answer);
      },
      doc);
  record.representation(text);
}

// The options of the poses of views, checked. Throws Error.
PoseOptions pose_options(double sigma_px, bool reject_outliers, int max_iterations,
                         std::uint64_t seed);

// A sentence of the library as a user of Python needs it: options of the command ("--model auto")
// become arguments ("model=\"auto\""). Those of a whole command ("tagcal convert FILE --to ..") and
// unknown ones stay.
std::string in_python(std::string_view sentence);
std::vector<std::string> in_python(const std::vector<std::string>& sentences);

}  // namespace tagcal::python
