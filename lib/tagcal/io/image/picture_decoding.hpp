#pragma once

#include "tagcal/io/image/image_codec.hpp"

// Private to io: pictures of decoders, turned upright. Each takes what a decoder passes on, once.
namespace tagcal::internal {

Image8 decode_grey8(ImageDecoder& decoder);            // as read_image
Picture decode_picture(ImageDecoder& decoder);         // as read_picture
Image8 scaled_by_brightest(const ImageView16& image);  // as scaled_to_8_bits

}  // namespace tagcal::internal
