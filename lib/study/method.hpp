#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

// What studies compare: ours and the peers' behind one interface.

namespace tagcal::study {

// A task in the form that a method takes it: what is timed, and what came of the last time.
template <typename Answer>
struct Prepared {
  std::function<void()> solve;
  std::function<Answer()> answer;
};

// The same of a method that may throw: then it has no answer.
template <typename Answer>
Prepared<std::optional<Answer>> guarded(Prepared<Answer> prepared) {
  const auto threw = std::make_shared<bool>(false);
  return {[threw, solve = std::move(prepared.solve)] {
            *threw = false;
            try {
              solve();
            } catch (const std::exception&) {
              *threw = true;
            }
          },
          [threw, answer = std::move(prepared.answer)]() -> std::optional<Answer> {
            if (*threw) return std::nullopt;
            return answer();
          }};
}

// A way to solve one class of problems.
template <typename Task, typename Answer>
struct Method {
  std::string name;
  std::function<Prepared<Answer>(const Task&)> prepare;
  std::string settings = {};  // how it is called, for readers
};

}  // namespace tagcal::study
