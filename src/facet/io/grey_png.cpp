// SPDX-License-Identifier: BSD-2-Clause
// "RFC" is the PNG specification, RFC 2083.
#include "facet/io/grey_png.h"

#ifdef FACET_HAS_LIBDEFLATE

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>

#include <libdeflate.h>

#include "facet/io/sample_depth.h"

namespace facet {
namespace {

using Byte = std::uint8_t;

// No deflate stream holds more bytes than this many times its own.
constexpr std::size_t kMostInflation = 1032;
constexpr std::size_t kSignature = 8, kHeaderLength = 13;

std::uint32_t BigEndian(const Byte* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | bytes[3];
}

struct Chunk {
  std::string_view type;
  Bytes data;
  bool is_whole = true;  // by its checksum

  bool IsCritical() const { return (type[0] & 0x20) == 0; }  // RFC 3.3
};

/// Goes through the chunks of a file.
class ChunkReader {
 public:
  explicit ChunkReader(Bytes file) : rest_(file) {}

  /// Empty where the file ends within a chunk.
  std::optional<Chunk> Next() {
    constexpr std::size_t kAround = 12;  // length and type before the data, checksum behind
    if (rest_.size() < kAround) return std::nullopt;
    const std::size_t length = BigEndian(rest_.data());
    if (length > rest_.size() - kAround) return std::nullopt;
    Chunk chunk;
    // The type is four letters in bytes.
    chunk.type = {reinterpret_cast<const char*>(rest_.data()) + 4, 4};
    chunk.data = rest_.subspan(8, length);
    chunk.is_whole = !chunk.IsCritical() || libdeflate_crc32(0, rest_.data() + 4, length + 4) ==
                                                BigEndian(rest_.data() + 8 + length);
    rest_ = rest_.subspan(kAround + length);
    return chunk;
  }

 private:
  Bytes rest_;
};

struct GreyHeader {
  std::uint32_t width = 0, height = 0;
  std::size_t sample_bytes = 1;
};

/// Empty for what is not grey with 8 or 16 bits, one row after the other.
std::optional<GreyHeader> HeaderOf(const Chunk& chunk) {
  if (chunk.type != "IHDR" || chunk.data.size() != kHeaderLength || !chunk.is_whole)
    return std::nullopt;
  const Byte* data = chunk.data.data();
  const Byte depth = data[8], colour = data[9], compression = data[10], filters = data[11],
             interlace = data[12];
  if ((depth != 8 && depth != 16) || colour != 0 || compression != 0 || filters != 0 ||
      interlace != 0) {
    return std::nullopt;
  }
  return GreyHeader{BigEndian(data), BigEndian(data + 4), depth / std::size_t{8}};
}

/// The compressed image, put together in `joined`, which is empty before, if it lies in several
/// chunks; empty if anything about them is odd.
Bytes CompressedImage(ChunkReader& chunks, std::vector<Byte>& joined) {
  Bytes image;
  bool is_behind = false;
  while (const auto chunk = chunks.Next()) {
    if (!chunk->is_whole) return {};
    if (chunk->type == "IEND") return image;
    if (chunk->type != "IDAT") {
      if (chunk->IsCritical()) return {};
      is_behind = !image.empty();
      continue;
    }
    if (is_behind) return {};
    if (image.empty()) {
      image = chunk->data;
      continue;
    }
    if (joined.empty()) joined.assign(image.begin(), image.end());
    joined.insert(joined.end(), chunk->data.begin(), chunk->data.end());
    image = joined;
  }
  return {};
}

bool Inflate(Bytes compressed, Byte* out, std::size_t size) {
  static thread_local const std::unique_ptr<libdeflate_decompressor,
                                            decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  return decompressor &&
         libdeflate_zlib_decompress(
             decompressor.get(), compressed.data(), compressed.size(), out, size, nullptr) ==
             LIBDEFLATE_SUCCESS;
}

int Paeth(int left, int up, int diagonal) {
  const int to_left = std::abs(up - diagonal), to_up = std::abs(left - diagonal);
  const int to_diagonal = std::abs(up - diagonal + left - diagonal);
  if (to_left <= to_up && to_left <= to_diagonal) return left;
  return to_up <= to_diagonal ? up : diagonal;
}

/// Adds to each byte what `predict` makes of the bytes to the left, above and diagonally before it;
/// there are zeros left of the first pixel, which has `kStep` bytes. `row` may be `filtered`
/// itself.
template <std::size_t kStep, class Predict>
void AddPrediction(
    const Byte* filtered, const Byte* above, std::size_t size, Byte* row, const Predict& predict) {
  Byte left[kStep] = {}, diagonal[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t k = 0; k < kStep; ++k) {
      const Byte up = above[i + k];
      left[k] = static_cast<Byte>(filtered[i + k] + predict(left[k], up, diagonal[k]));
      diagonal[k] = up;
      row[i + k] = left[k];
    }
  }
}

/// Takes a row's filter back (RFC 6). `above`: the row before, as it is in the end. False for a
/// filter that does not exist.
template <std::size_t kStep>
bool Unfilter(Byte filter, const Byte* filtered, const Byte* above, std::size_t size, Byte* row) {
  const auto add = [&](const auto& predict) {
    AddPrediction<kStep>(filtered, above, size, row, predict);
    return true;
  };
  switch (filter) {
    case 0:
      if (row != filtered) std::copy_n(filtered, size, row);
      return true;
    case 1:
      return add([](int left, int, int) { return left; });
    case 2:
      for (std::size_t i = 0; i < size; ++i)
        row[i] = static_cast<Byte>(filtered[i] + above[i]);
      return true;
    case 3:
      return add([](int left, int up, int) { return (left + up) / 2; });
    case 4:
      return add(Paeth);
    default:
      return false;
  }
}

}  // namespace

bool HasGreyPngDecoder() {
  return true;
}

bool DecodeGreyPng(Bytes file, std::vector<Byte>& scratch, GreyTarget& target) {
  if (file.size() < kSignature) return false;
  ChunkReader chunks(file.subspan(kSignature));
  const std::optional<Chunk> first = chunks.Next();
  const std::optional<GreyHeader> header = first ? HeaderOf(*first) : std::nullopt;
  if (!header) return false;
  if (!PrepareGrey(header->width, header->height, target)) return true;

  const std::size_t row_bytes = header->width * header->sample_bytes;
  const std::size_t num_bytes = header->height * (row_bytes + 1);  // a row begins with its filter
  scratch.clear();
  Bytes compressed = CompressedImage(chunks, scratch);
  if (compressed.empty() || num_bytes / kMostInflation > compressed.size()) return false;
  // Behind what was joined comes the image, and then a row of zeros, which is what lies above the
  // first one.
  const std::size_t begin = scratch.size();
  scratch.resize(begin + num_bytes + row_bytes);
  if (begin > 0) compressed = Bytes(scratch).first(begin);
  Byte* const rows = scratch.data() + begin;
  if (!Inflate(compressed, rows, num_bytes)) return false;
  std::fill_n(rows + num_bytes, row_bytes, Byte{0});

  const Byte* above = rows + num_bytes;
  for (int y = 0; y < target.image.rows; ++y) {
    Byte* filtered = rows + static_cast<std::size_t>(y) * (row_bytes + 1);
    Byte* grey = target.image.ptr(y);
    const Byte filter = *filtered++;
    if (header->sample_bytes == 1) {
      if (!Unfilter<1>(filter, filtered, above, row_bytes, grey)) return false;
      above = grey;
    } else {
      if (!Unfilter<2>(filter, filtered, above, row_bytes, filtered)) return false;
      above = filtered;
      for (int x = 0; x < target.image.cols; ++x) {
        const std::uint32_t sample = std::uint32_t{filtered[2 * x]} << 8 | filtered[2 * x + 1];
        grey[x] = ToEightBits(sample, target.sample_bits);
      }
    }
  }
  return true;
}

}  // namespace facet

#else

namespace facet {

bool HasGreyPngDecoder() {
  return false;
}

bool DecodeGreyPng(Bytes /*file*/, std::vector<std::uint8_t>& /*scratch*/, GreyTarget& /*target*/) {
  return false;
}

}  // namespace facet

#endif
