// SPDX-License-Identifier: BSD-2-Clause
// The PNG files that cameras write, decoded in a third of libpng's time: libdeflate inflates a
// whole image at once. Everything else is libpng's business (image_codecs.h).
#pragma once

#include <cstdint>
#include <vector>

#include "facet/io/image_codecs.h"

namespace facet {

/// Whether this program was built with libdeflate.
bool HasGreyPngDecoder();

/// Decodes grey PNG files with 8 or 16 bits that are not interlaced, to the same values as
/// DecodePng. False, without a complaint, for all others, for damaged ones, and without libdeflate;
/// the target may have been prepared by then. Throws InputError as PrepareGrey does. `scratch` is
/// kept for the next image.
bool DecodeGreyPng(Bytes file, std::vector<std::uint8_t>& scratch, GreyTarget& target);

}  // namespace facet
