#include "tagcal/estimate/findings/finding_codes.hpp"

#include <algorithm>
#include <cassert>

namespace tagcal::internal {

FindingCode refusal_code(Status status) {
  assert(!is_answer(status));
  return *std::ranges::find(kFindingCodes, status_name(status), &FindingCode::name);
}

}  // namespace tagcal::internal
