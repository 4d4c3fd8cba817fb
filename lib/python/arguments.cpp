#include "python/arguments.hpp"

#include <cmath>

#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

double positive(double value, const char* name) {
  if (!(value > 0) || !std::isfinite(value))
    throw Error(std::string(name) + ": must be > 0, got " + number(value));
  return value;
}

double not_negative(double value, const char* name, const char* zero) {
  if (!(value >= 0) || !std::isfinite(value))
    throw Error(std::string(name) + ": must be >= 0" +
                (zero == nullptr ? "" : " (0: " + std::string(zero) + ")") + ", got " +
                number(value));
  return value;
}

void check_positive(int value, const char* name) {
  if (value < 1) throw Error(std::string(name) + ": must be > 0, got " + std::to_string(value));
}

void check_threads(int threads) {
  if (threads < 0)
    throw Error("threads: must be >= 0 (0: one per core), got " + std::to_string(threads));
}

}  // namespace tagcal::python
