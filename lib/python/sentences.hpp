#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tagcal::python {

// A sentence of the library as a user of Python needs it: options of the command ("--model auto")
// become arguments ("model=\"auto\""). Those of a whole command ("tagcal convert FILE --to ..") and
// unknown ones stay.
std::string in_python(std::string_view sentence);
std::vector<std::string> in_python(const std::vector<std::string>& sentences);

}  // namespace tagcal::python
