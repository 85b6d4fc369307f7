// SPDX-License-Identifier: BSD-2-Clause
// How a component's options are listed once and then read, checked, printed and compared.
//
// Every options struct has one member
//   template <class Visitor> void Visit(Visitor& v) {
//     v.Field("max_features", max_features, {1, 5000}, "tracks kept per frame; more cost time");
//     v.Group("klt", klt);
//   }
// with its defaults at the declaration. Field types: bool, int, double, std::string; one of several
// texts or enumerators is a Choice. Whoever reads a file, prints the values in force or checks
// ranges supplies a Visitor (see io/config_file).
#pragma once

#include <limits>

namespace facet {

/// Whom an option is for: everybody sees those for users, `facet config --all` shows the others,
/// too.
enum class Audience { kExperts, kUsers };

/// An option of earlier versions. Saved configurations that hold it with the value that it had by
/// default are still read.
struct RetiredOption {
  const char* key;
  const char* default_text;  ///< as `facet config` printed it
  const char* new_key;       ///< the option that replaced it; empty: it is none any more
  const char* now = "";  ///< what it follows from instead; empty: it is fixed at its old default
};

/// Allowed range of a number, both ends included. Ignored for bool and std::string.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

}  // namespace facet
