// SPDX-License-Identifier: BSD-2-Clause
// The only source that is compiled for AVX2. Nothing may come from it that another one could use:
// functions of four lanes are instantiated here and nowhere else.
#include "facet/estimator/factors/vision_kernels.h"

namespace facet {

extern const VisionKernels kQuadKernels;
constexpr VisionKernels kQuadKernels = MakeVisionKernels<4>();

}  // namespace facet
