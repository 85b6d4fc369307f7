// SPDX-License-Identifier: BSD-2-Clause
// How a component's options are listed once and then read, checked, printed and compared.
//
// Every options struct has one member
//   template <class Visitor> void Visit(Visitor& v) {
//     v.Field("max_features", max_features, {1, 5000}, "tracks kept per frame; more cost time");
//     v.Group("klt", klt);
//   }
// with its defaults at the declaration. Field types: bool, int, double, std::string. Whoever reads
// a file, prints the values in force or checks ranges supplies a Visitor (see io/config_file).
#pragma once

#include <limits>

namespace facet {

/// Allowed range of a number, both ends included. Ignored for bool and std::string.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

}  // namespace facet
