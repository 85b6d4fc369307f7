// SPDX-License-Identifier: BSD-2-Clause
#include "image_keeper.h"

#include <mutex>
#include <string>
#include <vector>

#include "arrays.h"

namespace facet::python {
namespace {

void CheckKind(const py::array& array, const std::string& name) {
  if (array.dtype().kind() != 'u' || array.itemsize() != 1) {
    throw py::type_error(name + ": images are uint8, this array is " +
                         std::string(py::str(array.dtype())) +
                         "; 16 bit become 8 by (image >> 8).astype(numpy.uint8)");
  }
  if (array.ndim() != 2) {
    throw py::value_error(
        name + ": images are grey, of the shape (height, width), this array has " +
        ShapeText(array) + "; colours become grey by image.mean(axis=2).astype(numpy.uint8)");
  }
}

void CheckLayout(const py::array& array, int width, int height, const std::string& name) {
  if (array.shape(0) != height || array.shape(1) != width) {
    throw py::value_error(name + ": the calibration is for " + std::to_string(width) + " x " +
                          std::to_string(height) + " pixels, this image has " +
                          std::to_string(array.shape(1)) + " x " + std::to_string(array.shape(0)));
  }
  if (array.strides(1) != 1 || array.strides(0) < width) {
    throw py::value_error(name +
                          ": the pixels of a row must lie side by side and the rows one "
                          "behind the other; pass numpy.ascontiguousarray(" +
                          name + ")");
  }
}

}  // namespace

struct ImageKeeper::Bin {
  std::mutex mutex;
  std::vector<PyObject*> objects;
};

ImageKeeper::ImageKeeper() : bin_(std::make_shared<Bin>()) {}

ImageKeeper::~ImageKeeper() {
  Drop();
}

api::Image ImageKeeper::Keep(
    const py::object& object, int width, int height, bool copy, const char* name) {
  if (object.is_none()) return {};
  if (!py::isinstance<py::array>(object)) {
    throw py::type_error(std::string(name) +
                         ": an image is a numpy.ndarray of uint8 or None, not " +
                         std::string(py::str(py::type::of(object).attr("__name__"))));
  }
  const auto array = py::reinterpret_borrow<py::array>(object);
  CheckKind(array, name);
  CheckLayout(array, width, height, name);
  api::Image image;
  image.pixels = static_cast<const std::uint8_t*>(array.data());
  image.width = width;
  image.height = height;
  image.stride_bytes = static_cast<std::size_t>(array.strides(0));
  if (copy) return image;
  object.inc_ref();
  image.owner = std::shared_ptr<const void>(object.ptr(), [bin = bin_](const void* kept) {
    const std::lock_guard lock(bin->mutex);
    bin->objects.push_back(static_cast<PyObject*>(const_cast<void*>(kept)));
  });
  return image;
}

void ImageKeeper::Drop() {
  std::vector<PyObject*> objects;
  {
    const std::lock_guard lock(bin_->mutex);
    objects.swap(bin_->objects);
  }
  for (PyObject* object : objects)
    Py_DECREF(object);
}

}  // namespace facet::python
