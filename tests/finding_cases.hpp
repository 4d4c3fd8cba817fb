#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

// Data that cause a finding, for every_finding_test and rig_findings_test.

namespace tagcal {

inline std::set<std::string> codes_of(const std::vector<Finding>& findings) {
  std::set<std::string> codes;
  for (const Finding& finding : findings) codes.insert(finding.code);
  return codes;
}

// What an estimate says: its status and the codes of its findings.
struct Said {
  Status status;
  std::set<std::string> codes;
};

struct Case {
  std::string code;
  Said said;
};

struct RigFindingCase {
  std::string code;
  std::function<Said()> say;
};
std::vector<RigFindingCase> cases_of_rigs();  // rig_findings_test.cpp
std::vector<Case> cases_of_fleets();          // fleet_test.cpp
std::vector<Case> cases_of_checks();          // check_camera_test.cpp

}  // namespace tagcal
