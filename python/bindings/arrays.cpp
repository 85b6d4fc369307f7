// SPDX-License-Identifier: BSD-2-Clause
#include "arrays.h"

namespace facet::python {
namespace {

using Contiguous = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string ShapeText(py::ssize_t num_rows, py::ssize_t num_columns) {
  return "(" + std::to_string(num_rows) + ", " + std::to_string(num_columns) + ")";
}

}  // namespace

std::string ShapeText(const py::array& array) {
  return py::str(array.attr("shape"));
}

py::array_t<std::int64_t> Stamps(const py::object& stamps, const char* name) {
  const py::array array = py::array::ensure(stamps);
  const bool are_integers =
      array && (array.dtype().kind() == 'i' || array.dtype().kind() == 'u' || array.size() == 0);
  if (!are_integers) {
    PyErr_Clear();
    throw py::type_error(std::string(name) +
                         ": stamps are integers, nanoseconds; seconds become them by "
                         "numpy.round(1e9 * seconds).astype(numpy.int64)");
  }
  return py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array);
}

Doubles Rows(const py::object& numbers,
             py::ssize_t num_rows,
             py::ssize_t num_columns,
             const char* name) {
  const Contiguous array = Contiguous::ensure(numbers);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + ": numbers are expected");
  }
  const bool is_row = num_rows == 1 && array.ndim() == 1 && array.shape(0) == num_columns;
  const bool is_table =
      array.ndim() == 2 && array.shape(0) == num_rows && array.shape(1) == num_columns;
  if (!is_row && !is_table) {
    const std::string expected =
        num_rows == 1 ? "(" + std::to_string(num_columns) + ",)" : ShapeText(num_rows, num_columns);
    throw py::value_error(std::string(name) + ": the shape " + expected +
                          " is expected, here it is " + ShapeText(array));
  }
  return array;
}

}  // namespace facet::python
