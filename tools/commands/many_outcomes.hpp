#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "job/command.hpp"
#include "report/fleet.hpp"

namespace tagcal::tools {

// The part of a data set's answer that is kept: the calibrations of a fleet would not fit into
// memory.
struct ManyOutcome {
  static constexpr std::size_t kNumColumns = 10;
  using Row = std::array<std::string, kNumColumns>;

  ExitCode code = kBadInput;
  std::string error;  // of bad input
  Row row;            // the last column is the time; "-": of an earlier run
  std::string advice;
  std::string json;
  FleetRow unit;
  std::string yaml;  // the calibration, until it is written
};

// The folder for the answers. It is removed again if it was created here and stays empty.
class AnswerFolder {
 public:
  // "": none. `shared`: with other processes that share it; each data set has a lock then. Throws
  // Error if it cannot be written, or another process writes it.
  AnswerFolder(std::filesystem::path folder, bool shared);
  ~AnswerFolder();
  AnswerFolder(const AnswerFolder&) = delete;
  AnswerFolder& operator=(const AnswerFolder&) = delete;

 private:
  std::filesystem::path folder_;
  bool is_new_ = false;
  int lock_ = -1;  // file systems without locks have none
};

// Keeps other processes from calibrating a data set into a folder at the same time: waits for them.
// It ends with the process, however that ends. File systems without locks have none.
class SetLock {
 public:
  SetLock(const std::filesystem::path& folder, const std::string& name);
  ~SetLock();
  SetLock(const SetLock&) = delete;
  SetLock& operator=(const SetLock&) = delete;

 private:
  int descriptor_;
};

// The outcomes in OUT/summary/NAME.json, one for each data set: for `tagcal fleet`, and for a later
// run of the same work (--resume). Equal inputs and options give equal bytes.
class KeptOutcomes {
 public:
  // `made_by`: the options that decide the answers, as text. Throws Error if the folder cannot be
  // made.
  KeptOutcomes(const std::filesystem::path& out, const std::string& made_by);

  SetLock lock(const std::string& name) const { return {folder_, name}; }

  // The outcome of a data set, if an earlier run came to one from the same inputs that is no error.
  // Throws Error if it had other options or was of another version.
  std::optional<ManyOutcome> find(const std::string& name, const std::string& inputs) const;

  // Throws Error if it cannot be written.
  void keep(const std::string& name, const std::string& inputs, const ManyOutcome& outcome) const;

 private:
  std::filesystem::path file_of(const std::string& name) const;

  std::filesystem::path folder_;
  std::string made_by_;
};

}  // namespace tagcal::tools
