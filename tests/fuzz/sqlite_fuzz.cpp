// Bags of rosbag2 in SQLite (sequences.hpp).
#include "fuzz/sequences.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tagcal::fuzz::Scratch scratch;
  tagcal::fuzz::check_bag(tagcal::fuzz::text_of(data, size), "a.db3", scratch);
  return 0;
}
