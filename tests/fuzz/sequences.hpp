#pragma once

#include <algorithm>

#include "fuzz/fuzz.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"

namespace tagcal::fuzz {

// A bag of this ending: what is read of it holds together, with a topic and without.
inline void check_bag(std::string_view bytes, const char* name, const Scratch& scratch) {
  const std::filesystem::path file = scratch.write(name, bytes);
  for (const std::filesystem::path& sequence :
       {file, std::filesystem::path(file.string() + ":/a")}) {
    ImageSequence about;
    if (!is_accepted([&] { about = read_sequence(sequence); })) continue;
    require(!about.times_s.empty(), "a sequence has frames");
    require(std::ranges::is_sorted(about.times_s), "times ascend");
    require(std::isfinite(about.times_s.back()) && std::isfinite(about.start_s),
            "times are finite");
    if (std::int64_t{about.size.width} * about.size.height > 1'000'000) continue;  // takes long
    for (std::size_t i = 0; i < std::min<std::size_t>(about.times_s.size(), 4); ++i) {
      Image8 grey;
      const bool is_grey = is_accepted([&] { grey = read_image(frame_path(sequence, i)); });
      const bool is_read = is_accepted([&] { read_picture(frame_path(sequence, i)); });
      require(is_grey == is_read, "grey and colour are read or refused alike");
      if (is_grey) require(grey.size() == about.size, "frames have one size");
    }
  }
}

}  // namespace tagcal::fuzz
