// SPDX-License-Identifier: BSD-2-Clause
// NumPy arrays as images of the facade, without a copy.
#pragma once

#include <memory>

#include <pybind11/numpy.h>

#include "facet/facet.h"

namespace facet::python {

/// Keeps arrays alive for as long as Facet refers to their pixels. Facet lets go of them while the
/// interpreter's lock is released, where no reference may be dropped, so they are dropped later.
class ImageKeeper {
 public:
  ImageKeeper();
  ImageKeeper(const ImageKeeper&) = delete;
  ImageKeeper& operator=(const ImageKeeper&) = delete;
  ~ImageKeeper();

  /// The pixels of `array`, or a missing image for None. With `copy` Facet copies them and the
  /// array may be used at once. Throws TypeError and ValueError for what is no image of this size.
  api::Image Keep(
      const pybind11::object& array, int width, int height, bool copy, const char* name);

  /// Drops what Facet has let go of. Needs the interpreter's lock.
  void Drop();

 private:
  struct Bin;
  std::shared_ptr<Bin> bin_;
};

}  // namespace facet::python
