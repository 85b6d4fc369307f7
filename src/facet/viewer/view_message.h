// SPDX-License-Identifier: BSD-2-Clause
// The protocol between program and page, version 1; viewer/src/protocol.ts reads what this writes.
//
// A message is one binary WebSocket message (or the body of a download), little endian:
//
//   byte  0  "FCTV"
//         4  uint16 version of the protocol
//         6  uint16 type, a MessageType
//         8  uint16 source: 0 the live run or the first result, 1 the second result
//        10  uint16 number of blocks
//        12  uint32 size of the message in bytes
//        16  int64  stamp in nanoseconds, 0 where there is none
//        24  uint32 index; its meaning depends on the type
//        28  uint32 CRC-32 (as in zlib) of all bytes from 32 on
//        32  the blocks
//
// A block, padded with zeros to a multiple of 8 bytes:
//
//   byte  0  uint16 name, a BlockName
//         2  uint8  type of its numbers, an ElementType
//         3  uint8  numbers per row
//         4  uint32 rows
//         8  the numbers, row by row
//
// Lengths are metres, angles radians, times milliseconds (stamps nanoseconds); coordinates are in
// W. A number that is not known is nan. Whoever reads passes over names and types it does not know.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "facet/base/types.h"

namespace facet {

inline constexpr std::uint16_t kViewProtocol = 1;

enum class MessageType : std::uint16_t {
  kHello = 1,      ///< text: JSON that says what is shown; comes first
  kMesh = 2,       ///< replaces the mesh `index`: 0 map, 1 horizon
  kMapPart = 3,    ///< replaces the part of the map in the cube `key`; without faces it is empty
  kFrames = 4,     ///< replaces the group `index` of frames; groups follow each other in time
  kKeyframes = 5,  ///< replaces all keyframes
  kPlanes = 6,     ///< text: JSON, replaces all planes
  kPoints = 7,     ///< replaces the landmarks
  kImage = 8,      ///< replaces the camera's image; text: what its triangles are of
  kTruth = 9,      ///< the true trajectory, at the stamps of frames
  kEnded = 10      ///< text: JSON with code and message; the run is over
};

enum class BlockName : std::uint16_t {
  kText = 1,       ///< uint8 x 1: UTF-8
  kPositions = 2,  ///< float x 3
  kNormals = 3,    ///< int8 x 4: 127 times the unit normal, and 0
  kColours = 4,    ///< uint8 x 4: red, green, blue, 255
  kFaces = 5,      ///< uint32 x 3: rows of positions
  kPlaneIds = 6,   ///< int32 x 1 per face, -1: on no plane
  kStamps = 7,     ///< int64 x 1 [ns]
  kPoses = 8,      ///< float x 7: p_WB, q_WB (wxyz)
  kMotion = 9,     ///< float x 9: v_WB, b_g, b_a
  kSigmas = 10,    ///< float x 15: 1-sigma of p, theta, v, b_g, b_a
  kFlags = 11,   ///< uint32 x 1: bit 0 has a pose, bit 1 keyframe, bits 8-9 status, from 16 segment
  kStages = 12,  ///< float x number of stages [ms]
  kCounts = 13,  ///< float x 5: wall ms, latency ms, landmarks, planes, constraints
  kSigma = 14,   ///< float x 1 per position: 1-sigma of its distance from the camera
  kError = 15,   ///< float x 1 per position: distance to the true surface
  kImage = 16,   ///< uint8 x 1: a JPEG file
  kPixels = 17,  ///< float x 2 per track, in the image of kImage
  kDepths = 18,  ///< float x 1 per track: along the optical axis
  kTriangles = 19,  ///< uint32 x 3: rows of pixels
  kKey = 20,        ///< int32 x 3, one row
  kIds = 21         ///< float x 1 per track or landmark: its id modulo 2^24
};

enum class ElementType : std::uint8_t {
  kUint8 = 1,
  kInt8 = 2,
  kInt32 = 3,
  kUint32 = 4,
  kFloat = 5,
  kInt64 = 6
};

template <class T>
inline constexpr ElementType kElementType = ElementType::kUint8;
template <>
inline constexpr ElementType kElementType<std::int8_t> = ElementType::kInt8;
template <>
inline constexpr ElementType kElementType<std::int32_t> = ElementType::kInt32;
template <>
inline constexpr ElementType kElementType<std::uint32_t> = ElementType::kUint32;
template <>
inline constexpr ElementType kElementType<float> = ElementType::kFloat;
template <>
inline constexpr ElementType kElementType<std::int64_t> = ElementType::kInt64;

/// Builds one message.
class ViewMessage {
 public:
  struct Header {
    MessageType type = MessageType::kHello;
    int source = 0;
    Timestamp stamp{};
    std::uint32_t index = 0;
  };
  explicit ViewMessage(const Header& header);

  /// CHECKs that the numbers fill whole rows. Empty blocks may be left out.
  template <class T>
  void Add(BlockName name, std::span<const T> numbers, int per_row) {
    static_assert(sizeof(T) == 1 || kElementType<T> != ElementType::kUint8, "type has no name");
    AddBlock(name,
             kElementType<T>,
             {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()},
             numbers.size(),
             per_row);
  }
  void AddText(std::string_view text) { Add(BlockName::kText, std::span(text), 1); }

  /// The bytes; the message is then empty.
  std::string Finish();

 private:
  void AddBlock(BlockName name,
                ElementType type,
                std::string_view bytes,
                std::size_t num_numbers,
                int per_row);

  std::string bytes_;
  int num_blocks_ = 0;
};

}  // namespace facet
