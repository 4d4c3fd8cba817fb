#pragma once

#include <functional>
#include <string>

// What studies compare: ours and the peers' behind one interface.

namespace tagcal {

// A task in the form that a method takes it: what is timed, and what came of the last time.
template <typename Answer>
struct Prepared {
  std::function<void()> solve;
  std::function<Answer()> answer;
};

// A way to solve one class of problems.
template <typename Task, typename Answer>
struct Method {
  std::string name;
  std::function<Prepared<Answer>(const Task&)> prepare;
  std::string settings = {};  // how it is called, for readers
};

}  // namespace tagcal
