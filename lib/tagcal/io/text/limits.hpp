#pragma once

#include <cstddef>
#include <cstdint>

// Private to io: the limits of inputs. docs/reference/limits.md states each of them, and a test
// compares the page with this file. A limit is far beyond what a camera, a board or a scene needs;
// beyond it a file is damaged, or made to take the memory. Boards have two limits of their own:
// kMaxBoardParts (scene/board.hpp) and kMaxPolygonCorners (scene/visibility/polygon.hpp).

namespace tagcal::internal::limits {

// ---- Text

inline constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20;  // CSV, vnl, TXT, lists
inline constexpr std::size_t kMaxYamlBytes = std::size_t{16} << 20;   // YAML, JSON, XML
inline constexpr int kMaxYamlDepth = 64;
inline constexpr int kMaxYamlValues = 2'000'000;  // an alias counts as one
inline constexpr std::size_t kMaxListedPoses = 1'000'000;

// ---- Cameras and scenes

inline constexpr int kMaxSidePx = 100'000;  // a side of an image that a file states
inline constexpr int kMaxMatrixSide = 100'000;
inline constexpr std::size_t kMaxBoards = 10'000;  // of a file, with kMaxBoardParts parts in all
inline constexpr int kMaxViews = 100'000;          // of a scene
inline constexpr std::size_t kMaxRigCameras = 64;
inline constexpr std::size_t kMaxSheets = 10'000;  // occluders, and as many cuboids
inline constexpr std::size_t kMaxFrames = 10'000;
inline constexpr std::size_t kMaxSteps = 100;          // of a frame's pose or motion
inline constexpr std::size_t kMaxValuesOfPath = 1000;  // that are spread over the views
inline constexpr std::size_t kMaxVignettingTerms = 10;

// ---- Pictures

inline constexpr std::uintmax_t kMaxPictureBytes = std::uintmax_t{1} << 30;
inline constexpr std::int64_t kMaxPixels = 100'000'000;

inline constexpr std::size_t kMaxSequenceFrames = 1'000'000;  // nine hours at 30 Hz
inline constexpr std::size_t kMaxBagTopics = 100'000;         // connections, or channels
// A chunk or a message, after decompression: a hundred megapixels of five bytes.
inline constexpr std::uint64_t kMaxBagChunkBytes = std::uint64_t{1} << 29;
// All compressed chunks of a bag together, for one byte of the file, from kMaxBagBytesOfFewBytes
// on: what a hostile file costs is so proportional to its length. LZ4 makes at most 255 bytes of
// one; pictures of a camera compress by 10 at most.
inline constexpr std::uint64_t kMaxBagBytesAByte = 1000;
inline constexpr std::uint64_t kMaxBagBytesOfFewBytes = std::uint64_t{1} << 28;

// Pixels for one byte of a file, from kMaxPixelsOfFewBytes on. Deflate makes at most 1032 bytes of
// one (zlib's technical note), JPEG 256 pixels (two bits for a block of 64); WebP, CCITT and
// Zstandard make a hundred megapixels of one colour from 50 bytes.
inline constexpr std::int64_t kMaxPixelsAByte = 2000;
inline constexpr std::int64_t kMaxPixelsOfFewBytes = 4'000'000;

// Passes over the pixels of a progressive JPEG: each can cost as much as decoding the picture, and
// ten bytes ask for one. Cameras write 10 of them; 500 is what libjpeg-turbo's own fuzzers allow.
inline constexpr int kMaxJpegScans = 500;

}  // namespace tagcal::internal::limits
