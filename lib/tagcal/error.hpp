#pragma once

#include <stdexcept>

namespace tagcal {

// Bad input. The message is one line for the user and names the file, the key and the value, e.g.
// "desk.yaml: boards[1].tag_size: must be > 0, got -0.03". Thrown by io, detect and by constructors
// whose arguments come from a user; an estimate that fails says so in its status instead.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tagcal
