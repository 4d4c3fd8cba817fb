#include "tagcal/internal/processor.hpp"

#include <cstdlib>
#include <string>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

bool decide() {
  const char* const asked = std::getenv("TAGCAL_PROCESSOR");
  if (!asked || !*asked) return has_avx2();
  if (std::string(asked) == "any") return false;
  throw Error("TAGCAL_PROCESSOR: must be empty or \"any\", got \"" + std::string(asked) + "\"");
}

}  // namespace

bool runs_avx2() {
  static const bool runs = decide();
  return runs;
}

}  // namespace tagcal::internal
