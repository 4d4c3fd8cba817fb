#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

// One interface for the methods that studies compare: ours and the peers'.

namespace tagcal::study {

// A task in the form that a method takes it.
template <typename Answer>
struct Prepared {
  std::function<void()> solve;     // the part that is timed; may be called several times
  std::function<Answer()> answer;  // of the last call of `solve`
};

// Calls solve(state), then answer(state); both may be members of the state.
template <typename Answer, typename State, typename Solve, typename Read>
Prepared<Answer> prepare_state(State state, Solve solve, Read answer) {
  const auto shared = std::make_shared<State>(std::move(state));
  return {[shared, solve] { std::invoke(solve, *shared); },
          [shared, answer]() -> Answer { return std::invoke(answer, *shared); }};
}

// Keeps result = solve(task) for answer(result).
template <typename Answer, typename Task, typename Solve, typename Read = std::identity>
Prepared<Answer> prepare_task(Task task, Solve solve, Read answer = {}) {
  struct State {
    Task task;
    std::invoke_result_t<Solve, Task&> result{};
  };
  return prepare_state<Answer>(
      State{std::move(task)}, [solve](State& s) { s.result = solve(s.task); },
      [answer](const State& s) -> Answer { return answer(s.result); });
}

// Replaces the answer by judge(answer).
template <typename Answer, typename Judge>
Prepared<std::invoke_result_t<Judge, Answer>> judged(Prepared<Answer> prepared, Judge judge) {
  return {std::move(prepared.solve),
          [judge, answer = std::move(prepared.answer)] { return judge(answer()); }};
}

// Turns exceptions of `solve` into a missing answer.
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

// A method that solves one class of tasks.
template <typename Task, typename Answer>
struct Method {
  std::string name;
  std::function<Prepared<Answer>(const Task&)> prepare;
  std::string settings = {};  // how it is called, for readers

  bool ours() const { return name.starts_with("tagcal"); }
};

}  // namespace tagcal::study
