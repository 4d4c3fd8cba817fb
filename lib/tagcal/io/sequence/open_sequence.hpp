#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tagcal/io/sequence/frame_sequence.hpp"

// Private to io: the kinds of sequences, by the ends of their names.
namespace tagcal::internal {

bool is_sequence_ending(const std::string& ending);  // in lower case

// The sequence of a name that was read before and has not changed, or a new one. Throws Error.
std::shared_ptr<FrameSequence> frame_sequence(const std::filesystem::path& sequence);

}  // namespace tagcal::internal
