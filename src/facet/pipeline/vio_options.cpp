// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/vio_options.h"

namespace facet {

const char* ToString(Formulation formulation) {
  switch (formulation) {
    case Formulation::kS:
      return "S";
    case Formulation::kSP:
      return "SP";
    case Formulation::kSPR:
      return "SPR";
  }
  return "";
}

}  // namespace facet
