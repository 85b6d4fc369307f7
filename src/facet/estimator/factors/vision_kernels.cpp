// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/vision_kernels.h"

namespace facet {

#ifdef FACET_HAS_AVX2
extern const VisionKernels kQuadKernels;  // vision_kernels_avx2.cpp
#endif

const VisionKernels& PairKernels() {
  static constexpr VisionKernels kKernels = MakeVisionKernels<2>();
  return kKernels;
}

const VisionKernels* QuadKernels() {
#ifdef FACET_HAS_AVX2
  if (__builtin_cpu_supports("avx2") != 0) return &kQuadKernels;
#endif
  return nullptr;
}

const VisionKernels& BestKernels() {
  static const VisionKernels& kBest = QuadKernels() != nullptr ? *QuadKernels() : PairKernels();
  return kBest;
}

}  // namespace facet
