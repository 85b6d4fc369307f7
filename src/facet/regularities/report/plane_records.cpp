// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_records.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "facet/geometry/angles.h"
#include "facet/regularities/track/plane_merge.h"

namespace facet {

namespace {

constexpr AgreementLimits kOneSurface = {kSamePlaneAngle, 0.05};
constexpr double kLargestFurniture_m2 = 4;
// Planes smaller than this must be flat, or they are rows of things; walls may have things on them.
constexpr double kSmall_m2 = 1;
constexpr double kMaxScatterOfSmall = 0.5;
constexpr int kMinJudged = 5;  // keyframes
// As well as walls and leaning boards differ, the normal of a small plane must have been known
// once.
constexpr double kMaxSigmaOfSmall = 2 * kDegree;  // [rad]

// What is larger than furniture goes on behind what hides it, about as far as it is wide.
double LargestGap_m(const TrackedPlane& a, const TrackedPlane& b) {
  const double area_m2 = std::min(a.extent.area_m2(), b.extent.area_m2());
  return area_m2 > kLargestFurniture_m2 ? std::sqrt(area_m2) : kPlaneGrowth_m;
}

// With the uncertainty in the world instead of the one seen from the newest camera.
PlaneEstimate InWorld(PlaneEstimate estimate) {
  estimate.covariance.topRows<6>().setZero();
  estimate.covariance.leftCols<6>().setZero();
  return estimate;
}

bool AreOneSurface(const TrackedPlane& a, const TrackedPlane& b) {
  const Plane &plane_a = a.best->plane_W, &plane_b = b.best->plane_W;
  // Half-way between them neither has to reach far.
  const Vector3d middle_W = (a.extent.Centroid(plane_a) + b.extent.Centroid(plane_b)) / 2;
  const auto on = [&](const Plane& plane) {
    return Vector3d(middle_W - plane.SignedDistance(middle_W) * plane.n);
  };
  return Agree(InWorld(*a.best), on(plane_a), InWorld(*b.best), on(plane_b), SE3(), kOneSurface) &&
         a.extent.IsNear(b.extent, plane_b, LargestGap_m(a, b));
}

bool IsRowOfThings(const TrackedPlane& plane) {
  return plane.extent.area_m2() < kSmall_m2 && plane.fit.scatter.num >= kMinJudged &&
         plane.fit.scatter.mean > kMaxScatterOfSmall;
}

// A plane is curved if it was in most keyframes: one that only in the end gets landmarks of another
// surface was flat before.
bool IsCurved(const TrackedPlane& plane) {
  return plane.fit.curvature.num_judged >= kMinJudged &&
         2 * plane.fit.curvature.num_curved > plane.fit.curvature.num_judged;
}

// Mean of both directions [rad^2].
double NormalVariance(const TrackedPlane& plane) {
  return std::max(plane.best->covariance.block<3, 3>(6, 6).trace() / 2, 0.0);
}

bool IsPoorlyKnown(const TrackedPlane& plane) {
  return plane.extent.area_m2() < kSmall_m2 &&
         NormalVariance(plane) > kMaxSigmaOfSmall * kMaxSigmaOfSmall;
}

void MergeScatter(const TrackedPlane& part, TrackedPlane& whole) {
  const double a = part.fit.scatter.num * part.extent.area_m2();
  const double b = whole.fit.scatter.num * whole.extent.area_m2();
  if (a + b > 0)
    whole.fit.scatter.mean = (a * part.fit.scatter.mean + b * whole.fit.scatter.mean) / (a + b);
  whole.fit.scatter.num = std::max(part.fit.scatter.num, whole.fit.scatter.num);
}

// `planes` is sorted by id. The result has the id of the oldest and the estimate of the best one.
void Unite(std::vector<TrackedPlane>& planes) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = i + 1; j < planes.size();) {
      if (!AreOneSurface(planes[i], planes[j])) {
        ++j;
        continue;
      }
      MergeScatter(planes[j], planes[i]);
      planes[i].Merge(planes[j], planes[j].best->plane_W);
      if (NormalVariance(planes[j]) < NormalVariance(planes[i])) {
        planes[i].best = planes[j].best;
        planes[i].orientation = planes[j].orientation;
      }
      planes.erase(planes.begin() + static_cast<std::ptrdiff_t>(j));
      j = i + 1;  // what did not agree with it before may do so now
    }
  }
}

PlaneRecord MakeRecord(const TrackedPlane& plane) {
  PlaneRecord record;
  record.id = plane.id;
  record.plane_W = plane.best->plane_W;
  record.centroid_W = plane.extent.Centroid(record.plane_W);
  record.orientation = plane.orientation;
  record.first_seen = plane.seen.first;
  record.last_seen = plane.seen.last;
  record.num_landmarks = plane.landmark_count.num();
  record.merged_ids = plane.merged_ids;
  record.area_m2 = plane.extent.area_m2();
  record.outline_W = plane.extent.Outline(record.plane_W);
  const Matrix<10, 10>& covariance = plane.best->covariance;
  record.sigma_normal_rad = std::sqrt(NormalVariance(plane));
  Matrix<1, 4> J;  // d = offset + n . anchor
  J << plane.best->anchor_W.transpose(), 1;
  record.sigma_d_m =
      std::sqrt(std::max((J * covariance.bottomRightCorner<4, 4>() * J.transpose())(0), 0.0));
  return record;
}

}  // namespace

std::vector<PlaneRecord> MakeRecords(std::span<const TrackedPlane> planes, bool may_unite) {
  std::vector<TrackedPlane> solved;
  std::copy_if(planes.begin(), planes.end(), std::back_inserter(solved), [](const auto& plane) {
    return plane.best.has_value();
  });
  std::sort(solved.begin(), solved.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  if (may_unite) Unite(solved);
  std::erase_if(solved, [](const TrackedPlane& plane) {
    return IsRowOfThings(plane) || IsPoorlyKnown(plane) || IsCurved(plane);
  });
  std::vector<PlaneRecord> records;
  std::transform(solved.begin(), solved.end(), std::back_inserter(records), MakeRecord);
  return records;
}

}  // namespace facet
