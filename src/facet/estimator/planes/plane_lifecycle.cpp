// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_lifecycle.h"

#include <algorithm>

#include "facet/estimator/planes/plane_anchor.h"
#include "facet/estimator/planes/plane_budget.h"
#include "facet/estimator/planes/plane_judgement.h"
#include "facet/estimator/planes/plane_membership.h"

namespace facet {

namespace {

// So many wrong members never bend a window.
constexpr int kFewWrongMembers = 5;

}  // namespace

void PlaneLifecycle::Announce(const PlaneAssignments& assignments) {
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(assignments.created, waiting_.created);
  append(assignments.joined, waiting_.joined);
  append(assignments.left, waiting_.left);
  append(assignments.ended, ended_);
  append(assignments.related, waiting_.related);
  append(assignments.sighted, waiting_.sighted);
  append(assignments.projected, waiting_.projected);
  append(assignments.unprojected, waiting_.unprojected);
}

void PlaneLifecycle::TakeEffect(const FactorNoise& noise,
                                const FrameGeometry& geometry,
                                SlidingWindow& window) {
  if (window.planes.empty() && waiting_.IsEmpty()) return;
  ApplyAssignments(waiting_, options_, noise, geometry, window);
  ApplyProjections(waiting_, convert_back_, window);
  waiting_ = {};
  RemoveUnsupportedPlanes(options_.min_landmarks, window);
  FollowSupport(options_.anchor_distance_m, window);
  WeighPlanes(noise, window);
}

bool PlaneLifecycle::DropWrongMembers(const FactorNoise& noise,
                                      const FrameGeometry& geometry,
                                      SlidingWindow& window) const {
  const int before = window.NumMembers();
  if (before == 0) return false;
  const int dropped = DetachOutliers(geometry, noise, options_.outlier_sigma, window);
  return dropped > std::max(kFewWrongMembers, before / 10);
}

void PlaneLifecycle::Judge(const std::vector<Matrix3d>& information,
                           const std::vector<Matrix<9, 9>>& covariances,
                           const FactorNoise& noise,
                           SlidingWindow& window) {
  if (!window.planes.empty()) {
    MarkSettledPlanes(information, options_, window);
    DropViolatedRelations(noise.relations, options_.relations.outlier_sigma, window);
    for (const PlaneId id : ExcessPlanes(window, information, options_.max_planes))
      ended_.push_back(id);
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
  DetachOutliers(geometry, noise, options_.outlier_sigma, window);
  RemoveUnsupportedPlanes(options_.min_landmarks, window);
}

void PlaneLifecycle::RemoveEnded(SlidingWindow& window) {
  std::erase_if(ended_, [&](PlaneId id) {
    const int plane = window.IndexOf(id);
    if (plane < 0) return true;
    if (window.planes[plane].frozen) return false;
    window.RemovePlane(plane);
    return true;
  });
}

void PlaneLifecycle::EndIn(const SlidingWindow& window, MarginalizationPlan& plan) {
  for (const PlaneId id : ended_) {
    const int plane = window.IndexOf(id);
    if (plane >= 0) plan.drop_plane[plane] = 1;
  }
  ended_.clear();
}

void PlaneLifecycle::CutUnsettled(const MarginalizationPlan& plan, SlidingWindow& window) {
  CutUnsettledLinks(plan.drop_landmark, window);
  CutSightings(plan.drop_frame, window);
  CutUnsettledRelations(plan.drop_plane, window);
}

}  // namespace facet
