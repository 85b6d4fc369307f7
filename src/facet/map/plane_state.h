// SPDX-License-Identifier: BSD-2-Clause
// The life of a plane. docs/architecture.md, "The life of a plane", draws the transitions.
#pragma once

namespace facet {

enum class PlaneState {
  kTentative,   ///< detected in some keyframes; the estimator does not know it
  kConfirmed,   ///< a variable of the estimator, which may still drop it
  kPersistent,  ///< determined well enough to enter the marginalisation prior; no longer dropped
                ///< for being hardly known, but still ended by misfit, merging or a lack of room
  kRetired      ///< the estimator no longer has it
};

}  // namespace facet
