// SPDX-License-Identifier: BSD-2-Clause
// Between NumPy's arrays and plain data.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace facet::python {

namespace py = pybind11;

using Doubles = py::array_t<double>;

/// A copy.
template <std::size_t N>
Doubles ToArray(const std::array<double, N>& values) {
  return Doubles(static_cast<py::ssize_t>(N), values.data());
}

/// A view of rows of N numbers that lie one behind the other; `owner` keeps them alive.
template <class T, std::size_t N>
py::array_t<T> RowsView(const std::vector<std::array<T, N>>& rows, py::handle owner) {
  static_assert(sizeof(std::array<T, N>) == N * sizeof(T));
  const auto num_rows = static_cast<py::ssize_t>(rows.size());
  const T* data = rows.empty() ? nullptr : rows.front().data();
  return py::array_t<T>({num_rows, static_cast<py::ssize_t>(N)}, data, owner);
}

template <class T>
py::array_t<T> View(const std::vector<T>& values, py::handle owner) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data(), owner);
}

/// "(480, 752, 3)".
std::string ShapeText(const py::array& array);

/// The stamps as integers; throws TypeError for others, because seconds would be cut off.
py::array_t<std::int64_t> Stamps(const py::object& stamps, const char* name);

/// Numbers of the shape (num_rows, num_columns), in rows. Throws ValueError.
Doubles Rows(const py::object& numbers,
             py::ssize_t num_rows,
             py::ssize_t num_columns,
             const char* name);

/// N numbers. Throws ValueError.
template <std::size_t N>
std::array<double, N> ToNumbers(const py::object& numbers, const char* name) {
  std::array<double, N> values;
  const Doubles row = Rows(numbers, 1, static_cast<py::ssize_t>(N), name);
  std::copy_n(row.data(), N, values.begin());
  return values;
}

}  // namespace facet::python
