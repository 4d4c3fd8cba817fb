#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "tagcal/io/image/image_codec.hpp"

// Private to io: the messages sensor_msgs/Image and sensor_msgs/CompressedImage.
// https://docs.ros.org/en/api/sensor_msgs/html/msg/Image.html, and the same in ROS 2.
namespace tagcal::internal {

enum class RosCoding {
  ros1,  // little-endian, unaligned
  cdr,   // of ROS 2: OMG's Common Data Representation, with its four bytes before the message
};

inline constexpr std::size_t kStampBytes = 12;  // of a message, with which its time stamp ends

bool is_ros_picture(std::string_view type);  // "sensor_msgs/Image" or "sensor_msgs/CompressedImage"

std::int64_t ns_of(std::uint32_t seconds, std::uint32_t nanoseconds);

// The time stamp of a message that begins with these bytes; 0: none, or too few bytes.
std::int64_t ros_stamp_ns(std::string_view begin, RosCoding coding);

// The picture of a message of such a type; `message` must outlive it. Colours of a Bayer pattern
// are interpolated linearly; of YUV 4:2:2 the luma alone is taken. Throws Error: a size beyond the
// limits or the message's end, an encoding that is not read.
std::unique_ptr<ImageDecoder> ros_picture_decoder(std::string_view message, std::string_view type,
                                                  RosCoding coding);

}  // namespace tagcal::internal
