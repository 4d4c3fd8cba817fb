#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "job/command.hpp"
#include "job/work_file.hpp"

namespace tagcal::tools {

// The part of a data set's answer that is kept: the calibrations of a fleet would not fit into
// memory.
struct ManyOutcome {
  static constexpr std::size_t kNumColumns = 10;
  using Row = std::array<std::string, kNumColumns>;

  ExitCode code = kBadInput;
  std::string error;  // of bad input
  Row row;
  std::string advice;
  std::string json;
};

// The outcomes of an interrupted run, in OUT/.resume, for a later run of the same command.
class KeptOutcomes {
 public:
  // Throws Error if OUT/.resume is of another command, or in use by another process.
  explicit KeptOutcomes(const std::filesystem::path& out);

  // The outcome of a data set, if an earlier run came to one from the same inputs.
  std::optional<ManyOutcome> find(const std::string& name, const std::string& inputs) const;
  void keep(const std::string& name, const std::string& inputs, const ManyOutcome& outcome) const;

  // All data sets are done: removes what was kept.
  void finish() const;

 private:
  std::filesystem::path file_of(const std::string& name) const;

  std::filesystem::path folder_;
  WorkFile work_;
};

}  // namespace tagcal::tools
