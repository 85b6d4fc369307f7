// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/decompression.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "facet/io/errors.h"

namespace facet {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// The place that decompressed data go to. A step takes some input, gives some output, and says
/// whether the stream is at its end.
class GrowingOutput {
 public:
  GrowingOutput(std::uint64_t size, std::size_t input_size, std::vector<std::uint8_t>& buffer)
      : size_(size), buffer_(buffer) {
    constexpr std::uint64_t kFirst = 64 << 10;
    Grow(std::max<std::uint64_t>(kFirst, 8 * std::uint64_t{input_size}));
  }

  std::uint8_t* place() { return buffer_.data() + used_; }
  std::size_t room() const { return static_cast<std::size_t>(capacity_ - used_); }
  std::size_t used() const { return used_; }

  void Advance(std::size_t count) { used_ += count; }
  /// False where no more than the announced size may come.
  bool MakeRoom() {
    if (room() > 0) return true;
    if (capacity_ == size_) return false;
    Grow(2 * capacity_);
    return true;
  }

 private:
  void Grow(std::uint64_t wanted) {
    capacity_ = std::min(wanted, size_);
    if (buffer_.size() < capacity_) buffer_.resize(capacity_);
  }

  std::uint64_t size_, capacity_ = 0;
  std::size_t used_ = 0;
  std::vector<std::uint8_t>& buffer_;
};

[[noreturn]] void FailTooLong(std::uint64_t size) {
  throw InputError("the compressed data hold more than the announced " + std::to_string(size) +
                   " bytes");
}

void DecompressLz4(Bytes data, std::uint64_t size, GrowingOutput& output) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) {
    throw InputError("lz4 could not be started");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  while (true) {
    const bool has_room = output.MakeRoom();
    std::uint8_t beyond = 0;  // for what only ends the stream
    std::size_t room = has_room ? output.room() : 1, taken = data.size();
    const std::size_t hint = LZ4F_decompress(
        raw, has_room ? output.place() : &beyond, &room, data.data(), &taken, nullptr);
    if (LZ4F_isError(hint) != 0) {
      throw InputError(std::string("damaged lz4 data: ") + LZ4F_getErrorName(hint));
    }
    if (!has_room && room > 0) FailTooLong(size);
    if (has_room) output.Advance(room);
    data = data.subspan(taken);
    if (hint == 0) return;
    if (taken == 0 && room == 0) throw InputError("the lz4 data end too early");
  }
}

void DecompressZstd(Bytes data, std::uint64_t size, GrowingOutput& output) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          &ZSTD_freeDStream);
  if (!stream) throw InputError("zstd could not be started");
  ZSTD_initDStream(stream.get());
  ZSTD_inBuffer input{data.data(), data.size(), 0};
  while (true) {
    const bool has_room = output.MakeRoom();
    std::uint8_t beyond = 0;
    ZSTD_outBuffer out{has_room ? output.place() : &beyond, has_room ? output.room() : 1, 0};
    const std::size_t before = input.pos;
    const std::size_t hint = ZSTD_decompressStream(stream.get(), &out, &input);
    if (ZSTD_isError(hint) != 0) {
      throw InputError(std::string("damaged zstd data: ") + ZSTD_getErrorName(hint));
    }
    if (!has_room && out.pos > 0) FailTooLong(size);
    if (has_room) output.Advance(out.pos);
    if (hint == 0 && input.pos == input.size) return;
    if (input.pos == before && out.pos == 0) throw InputError("the zstd data end too early");
  }
}

void DecompressBz2(Bytes data, std::uint64_t size, GrowingOutput& output) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw InputError("bz2 could not be started");
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> owner(&stream,
                                                                         &BZ2_bzDecompressEnd);
  constexpr std::size_t kMax = std::numeric_limits<unsigned>::max() / 2;
  if (data.size() > kMax) throw InputError("a bz2 block of more than 2 GB");
  // The library takes its input by a pointer to char that is not const, and only reads.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
  stream.avail_in = static_cast<unsigned>(data.size());
  while (true) {
    const bool has_room = output.MakeRoom();
    std::uint8_t beyond = 0;
    const std::size_t room = has_room ? std::min(output.room(), kMax) : 1;
    stream.next_out = reinterpret_cast<char*>(has_room ? output.place() : &beyond);
    stream.avail_out = static_cast<unsigned>(room);
    const unsigned input_before = stream.avail_in;
    const int status = BZ2_bzDecompress(&stream);
    const std::size_t got = room - stream.avail_out;
    if (status != BZ_OK && status != BZ_STREAM_END) {
      throw InputError("damaged bz2 data (error " + std::to_string(status) + ")");
    }
    if (!has_room && got > 0) FailTooLong(size);
    if (has_room) output.Advance(got);
    if (status == BZ_STREAM_END) return;
    if (stream.avail_in == input_before && got == 0) {
      throw InputError("the bz2 data end too early");
    }
  }
}

}  // namespace

std::optional<Compression> CompressionFromText(std::string_view name) {
  if (name.empty() || name == "none") return Compression::kNone;
  if (name == "lz4") return Compression::kLz4;
  if (name == "bz2") return Compression::kBz2;
  if (name == "zstd") return Compression::kZstd;
  return std::nullopt;
}

Bytes Decompress(Compression compression,
                 Bytes data,
                 std::uint64_t size,
                 std::vector<std::uint8_t>& buffer) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
  if (compression != Compression::kNone && size > kMost) {
    throw InputError("announces " + std::to_string(size) +
                     " decompressed bytes; recorders write chunks of some megabytes");
  }
  std::size_t num = data.size();
  Bytes result = data;
  if (compression != Compression::kNone) {
    GrowingOutput output(size, data.size(), buffer);
    if (compression == Compression::kLz4) DecompressLz4(data, size, output);
    if (compression == Compression::kZstd) DecompressZstd(data, size, output);
    if (compression == Compression::kBz2) DecompressBz2(data, size, output);
    num = output.used();
    result = {buffer.data(), num};
  }
  if (num != size) {
    throw InputError("holds " + std::to_string(num) + " bytes, " + std::to_string(size) +
                     " are announced");
  }
  return result;
}

Bytes DecompressZstdFrame(Bytes data, std::vector<std::uint8_t>& buffer) {
  const unsigned long long size = ZSTD_getFrameContentSize(data.data(), data.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) {
    throw InputError("zstd data that do not say how many bytes they stand for");
  }
  return Decompress(Compression::kZstd, data, size, buffer);
}

}  // namespace facet
