#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/progress.hpp"
#include "studies/studies.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
using namespace study;
namespace {

struct StudyArguments {
  Study study;
  StudyOptions options;
  std::string csv;
};

int run(StudyArguments& a) {
  a.options.csv = a.csv;
  Progress progress("study " + a.study.name);
  const std::vector<Row> rows =
      run_study(a.study, a.options, [&](int done, int total) { progress.update(done, total); });
  print_result(tables_text(a.study, rows));
  return kAnswer;
}

}  // namespace

Command add_study(CLI::App& app, Study study) {
  CLI::App* command = add_command(app, study.name, study.summary);
  const auto a = std::make_shared<StudyArguments>(StudyArguments{std::move(study), {}, {}});
  a->options.count = a->study.count;
  a->options.first = a->study.first;
  if (!a->study.inputs.empty()) {
    Option inputs = add_option(*command, "INPUT", a->options.inputs, a->study.inputs);
    if (a->study.needs_inputs) inputs.required();
  }
  add_integer(*command, "--count", a->options.count, 1,
              fmt::format("trials of each task ({})", a->study.count));
  add_option(*command, "--first", a->options.first,
             fmt::format("number, or seed, of the first trial ({})", a->study.first))
      .text("N");
  add_integer(*command, "--threads", a->options.threads, 0,
              "trials side by side (1); 0: one per core");
  add_option(*command, "--csv", a->csv,
             "file of all trials; those that it has already are not repeated")
      .text("FILE");
  for (const StudyOption& option : a->study.options) {
    std::string& value = a->options.named[option.name] = option.value;
    add_option(*command, "--" + option.name, value,
               fmt::format("{} ({})", option.help, option.value.empty() ? "none" : option.value))
        .text("VALUE");
  }
  return {command, [a] { return run(*a); }};
}

}  // namespace tagcal::tools
