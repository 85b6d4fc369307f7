// SPDX-License-Identifier: BSD-2-Clause
// How well the system knows where it is.
#pragma once

namespace facet {

enum class TrackingStatus {
  kInitialising,  ///< no pose yet
  kOk,
  kDegraded,  ///< a pose, but vision or IMU says too little
  kLost       ///< the state is of no use; the estimator starts again
};

/// The word for states.csv.
inline const char* ToString(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kInitialising:
      return "initialising";
    case TrackingStatus::kOk:
      return "ok";
    case TrackingStatus::kDegraded:
      return "degraded";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "";
}

}  // namespace facet
