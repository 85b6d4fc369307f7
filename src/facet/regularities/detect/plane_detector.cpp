// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_detector.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/angles.h"
#include "facet/regularities/detect/region_growing.h"

namespace facet {

namespace {

// Faces that lean less vote for level or for upright planes.
constexpr double kMaxFaceLean = 15 * kDegree;
// Kernel of a vote, 1-sigma: height or distance, and azimuth.
constexpr double kVoteSigma_m = 0.03, kVoteSigma = 5 * kDegree;
// New planes of each kind per keyframe, at most: the next keyframe finds the others.
constexpr int kMaxCandidates = 6;

// Faces vote together with those whose length scale is at most twice as large, so that kernels are
// as wide as what is known there. The last layer has all that is farther than votes reach.
constexpr int kLastLayer = 5;
int LayerOf(const SurfaceFace& face) {
  return std::min(std::ilogb(face.length_scale), kLastLayer);
}

}  // namespace

std::vector<PlaneCandidate> PlaneDetector::Detect(const SurfaceFaces& faces,
                                                  const std::vector<char>& taken) {
  std::vector<PlaneCandidate> out;
  taken_ = taken;
  pool_.clear();
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    const SurfaceFace& face = faces.faces[f];
    if (face.may_vote && (face.in_view || !options_.only_in_view) && taken_[f] == 0)
      pool_.push_back(static_cast<int>(f));
  }
  int last_layer = 0;
  for (const int f : pool_)
    last_layer = std::max(last_layer, LayerOf(faces.faces[f]));
  for (int layer = 0; layer <= last_layer; ++layer) {
    FindLevel(faces, layer, out);
    FindUpright(faces, layer, out);
  }
  if (options_.oblique) FindOblique(faces, out);
  return out;
}

std::vector<int> PlaneDetector::Accept(const SurfaceFaces& faces,
                                       const Plane& start,
                                       double min_area_m2,
                                       std::vector<PlaneCandidate>& out) {
  const std::vector<int> around = FacesAround(faces, pool_, start);
  std::vector<int> near = FacesOnPlane(faces, around, start, options_.max_distance_m);
  if (SearchAreaOf(faces, near) < min_area_m2) return near;  // where a fit would begin
  for (PlaneCandidate& candidate : FitCandidates(faces, around, start, min_area_m2, options_)) {
    for (const int f : candidate.faces) {
      taken_[f] = 1;
      near.push_back(f);
    }
    const bool is_wanted = options_.oblique || candidate.orientation != PlaneOrientation::kOblique;
    if (is_wanted) out.push_back(std::move(candidate));
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::erase_if(pool_, [this](int f) { return taken_[f] != 0; });
  return near;
}

// What is found takes its votes back, so that it does not hide its neighbours.
template <class Votes, class Vote>
void PlaneDetector::TakePeaks(const SurfaceFaces& faces,
                              Votes& histogram,
                              const Vote& vote,
                              std::vector<PlaneCandidate>& out) {
  for (const int f : pool_) {
    if (has_voted_[f] != 0) vote(f, 1);
  }
  for (int k = 0; k < kMaxCandidates; ++k) {
    const auto peak = histogram.Highest();
    if (!peak || peak->area_m2 < options_.min_area_m2) return;
    for (const int f : Accept(faces, peak->plane_W, options_.min_area_m2, out)) {
      if (has_voted_[f] == 0) continue;
      vote(f, -1);
      has_voted_[f] = 0;
    }
    histogram.Erase(peak->plane_W);
  }
}

void PlaneDetector::FindLevel(const SurfaceFaces& faces,
                              int layer,
                              std::vector<PlaneCandidate>& out) {
  const double min_z = std::cos(kMaxFaceLean);
  has_voted_.assign(faces.faces.size(), 0);
  double lowest = 0, highest = 0;
  bool any = false;
  for (const int f : pool_) {
    const SurfaceFace& face = faces.faces[f];
    if (std::abs(face.n_W.z()) < min_z || LayerOf(face) != layer) continue;
    has_voted_[f] = 1;
    lowest = any ? std::min(lowest, face.centre_W.z()) : face.centre_W.z();
    highest = any ? std::max(highest, face.centre_W.z()) : face.centre_W.z();
    any = true;
  }
  if (!any) return;
  heights_.Reset(lowest, highest, std::ldexp(kVoteSigma_m, layer));
  const auto vote = [&](int f, double sign) {
    heights_.Add(faces.faces[f].centre_W.z(), sign * faces.faces[f].search_area_m2);
  };
  TakePeaks(faces, heights_, vote, out);
}

void PlaneDetector::FindUpright(const SurfaceFaces& faces,
                                int layer,
                                std::vector<PlaneCandidate>& out) {
  const double max_z = std::sin(kMaxFaceLean);
  has_voted_.assign(faces.faces.size(), 0);
  const Vector3d origin = options_.world_origin ? Vector3d(Vector3d::Zero()) : faces.camera.p_W;
  double radius = 0;
  for (const int f : pool_) {
    const SurfaceFace& face = faces.faces[f];
    if (std::abs(face.n_W.z()) > max_z || LayerOf(face) != layer) continue;
    has_voted_[f] = 1;
    radius = std::max(radius, (face.centre_W - origin).head<2>().norm());
  }
  if (radius == 0) return;
  walls_.Reset(origin, radius, std::ldexp(kVoteSigma_m, layer), kVoteSigma);
  const auto vote = [&](int f, double sign) {
    const SurfaceFace& face = faces.faces[f];
    const double weight = sign * face.search_area_m2;
    if (options_.world_origin) {
      walls_.AddOwnDistance(face.centre_W, face.n_W, weight);
    } else {
      walls_.Add(face.centre_W, face.n_W, weight);
    }
  };
  TakePeaks(faces, walls_, vote, out);
}

void PlaneDetector::FindOblique(const SurfaceFaces& faces, std::vector<PlaneCandidate>& out) {
  int found = 0;
  for (const Plane& region : GrowRegions(faces, pool_, options_.oblique_min_area_m2)) {
    if (found++ >= kMaxCandidates) return;
    Accept(faces, region, options_.oblique_min_area_m2, out);
  }
}

}  // namespace facet
