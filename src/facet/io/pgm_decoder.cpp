// SPDX-License-Identifier: BSD-2-Clause
// Portable grey map: P5 (binary, 8 or 16 bit big endian) and P2 (text), with comments.
#include <string>

#include "facet/io/errors.h"
#include "facet/io/image_codecs.h"

namespace facet {
namespace {

bool IsSpace(std::uint8_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

class PgmText {
 public:
  explicit PgmText(Bytes bytes) : bytes_(bytes) {}

  /// The next number of the header or of a P2 image; skips blanks and comments in front of it.
  int Number() {
    SkipBlanks();
    int value = 0;
    const std::size_t begin = position_;
    for (; position_ < bytes_.size() && bytes_[position_] >= '0' && bytes_[position_] <= '9';
         ++position_) {
      value = 10 * value + (bytes_[position_] - '0');
      if (value > 65536) throw InputError("damaged PGM: a number is too large");
    }
    if (position_ == bytes_.size() && begin == position_) throw InputError("truncated PGM");
    if (begin == position_) throw InputError("damaged PGM: a number is expected");
    return value;
  }

  /// Returns the bytes that follow the single blank behind the header.
  Bytes Rest() {
    if (position_ < bytes_.size()) ++position_;
    return bytes_.subspan(position_);
  }

 private:
  void SkipBlanks() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        while (position_ < bytes_.size() && bytes_[position_] != '\n')
          ++position_;
      } else if (!IsSpace(bytes_[position_])) {
        return;
      } else {
        ++position_;
      }
    }
  }

  Bytes bytes_;
  std::size_t position_ = 2;  // behind the magic
};

std::uint8_t ScaleTo8Bits(int value, int max_value) {
  if (value > max_value)
    throw InputError("damaged PGM: a pixel is above the maximum of the header");
  if (max_value == 255) return static_cast<std::uint8_t>(value);
  return static_cast<std::uint8_t>((value * 255 + max_value / 2) / max_value);
}

}  // namespace

void DecodePgm(Bytes file, GreyTarget& target) {
  const bool is_text = file[1] == '2';
  PgmText text(file);
  const int width = text.Number();
  const int height = text.Number();
  const int max_value = text.Number();
  if (max_value < 1 || max_value > 65535) throw InputError("damaged PGM: impossible maximum");
  if (!PrepareGrey(width, height, target)) return;
  cv::Mat& image = target.image;
  const Bytes pixels = is_text ? Bytes() : text.Rest();
  const std::size_t depth = max_value > 255 ? 2 : 1;
  if (!is_text && pixels.size() < depth * image.total()) throw InputError("truncated PGM");
  std::size_t i = 0;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* row = image.ptr(y);
    for (int x = 0; x < width; ++x, i += depth) {
      const int value = is_text      ? text.Number()
                        : depth == 1 ? pixels[i]
                                     : 256 * pixels[i] + pixels[i + 1];
      row[x] = ScaleTo8Bits(value, max_value);
    }
  }
}

}  // namespace facet
