// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_lifecycle.h"

#include <algorithm>

#include "facet/estimator/planes/plane_anchor.h"
#include "facet/estimator/planes/plane_budget.h"
#include "facet/estimator/planes/plane_judgement.h"
#include "facet/estimator/planes/plane_membership.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// Landmarks farther from their plane, and relations violated by more, are wrong: one in 10000 of
// those that are right.
constexpr double kMaxLandmarkSigma = 4.0, kMaxRelationSigma = 4.0;
// So many wrong landmarks never bend a window.
constexpr int kFewWrongLandmarks = 5;

}  // namespace

void PlaneLifecycle::Announce(const PlaneAssignments& assignments) {
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(assignments.created, waiting_.created);
  append(assignments.attached, waiting_.attached);
  append(assignments.detached, waiting_.detached);
  append(assignments.retired, retired_);
  append(assignments.unevenness, waiting_.unevenness);
  append(assignments.relations, waiting_.relations);
  append(assignments.measurements, waiting_.measurements);
  append(assignments.projected, waiting_.projected);
  append(assignments.unprojected, waiting_.unprojected);
}

void PlaneLifecycle::TakeEffect(const FactorNoise& noise,
                                const FrameGeometry& geometry,
                                SlidingWindow& window) {
  if (window.planes.empty() && waiting_.IsEmpty()) return;
  ApplyAssignments(waiting_, AttachmentLimits(), noise, geometry, evidence_, window);
  ApplyProjections(waiting_, convert_back_, window);
  waiting_ = {};
  RemoveSparsePlanes(options_.min_landmarks, window);
  FollowLandmarks(options_.anchor_distance_m, window);
  WeighPlanes(noise, window);
}

bool PlaneLifecycle::DetachWrongLandmarks(const FactorNoise& noise,
                                          const FrameGeometry& geometry,
                                          SlidingWindow& window) const {
  const int before = window.NumPlaneLandmarks();
  if (before == 0) return false;
  const int dropped = DetachOutliers(geometry, noise, kMaxLandmarkSigma, window);
  return dropped > std::max(kFewWrongLandmarks, before / 10);
}

void PlaneLifecycle::Judge(const std::vector<Matrix3d>& information,
                           const std::vector<Matrix<9, 9>>& covariances,
                           const FactorNoise& noise,
                           SlidingWindow& window) {
  if (!window.planes.empty()) {
    MarkPersistentPlanes(information, PersistenceLimits(), window);
    DropViolatedRelations(noise.relations, kMaxRelationSigma, window);
    for (const PlaneId id : ExcessPlanes(window, information, options_.max_planes))
      retired_.push_back(id);
  }
  KeepCovariances(covariances, window);
}

// From two tangent directions and offset to normal and offset, joint with the newest pose.
void PlaneLifecycle::KeepCovariances(const std::vector<Matrix<9, 9>>& covariances,
                                     const SlidingWindow& window) {
  covariances_.clear();
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    Matrix<10, 9> J = Matrix<10, 9>::Zero();
    J.topLeftCorner<6, 6>().setIdentity();
    J.block<3, 2>(6, 6) = TangentBasis(window.planes[k].n_lin);
    J(9, 8) = 1;
    covariances_.emplace_back(window.planes[k].id, J * covariances[k] * J.transpose());
  }
}

void PlaneLifecycle::FollowOutlierRemoval(const FactorNoise& noise,
                                          const FrameGeometry& geometry,
                                          SlidingWindow& window) const {
  if (window.planes.empty()) return;
  DetachOutliers(geometry, noise, kMaxLandmarkSigma, window);
  RemoveSparsePlanes(options_.min_landmarks, window);
}

void PlaneLifecycle::RemoveRetired(SlidingWindow& window) {
  std::erase_if(retired_, [&](PlaneId id) {
    const int plane = window.IndexOf(id);
    if (plane < 0) return true;
    if (window.planes[plane].frozen) return false;
    window.RemovePlane(plane);
    return true;
  });
}

void PlaneLifecycle::RetireIn(const SlidingWindow& window, MarginalizationPlan& plan) {
  for (const PlaneId id : retired_) {
    const int plane = window.IndexOf(id);
    if (plane >= 0) plan.drop_plane[plane] = 1;
  }
  retired_.clear();
}

void PlaneLifecycle::CutNonPersistent(const MarginalizationPlan& plan, SlidingWindow& window) {
  CutNonPersistentLinks(plan.drop_landmark, window);
  CutMeasurements(plan.drop_frame, window);
  CutNonPersistentRelations(plan.drop_plane, window);
  evidence_.UseUp(plan, window);
}

}  // namespace facet
