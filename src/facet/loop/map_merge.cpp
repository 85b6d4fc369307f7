// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/map_merge.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <set>
#include <utility>

#include "facet/loop/closure_check.h"
#include "facet/loop/place_index.h"

namespace facet {

namespace {

constexpr std::size_t kMostGuesses = 5;  // places of the first map for each of the second
// Fewer than with an image, where every point is looked for: both flights have to have chosen the
// same corner.
constexpr int kMinInliers = 15;
constexpr std::size_t kMinAgreeing = 3, kMinElsewhere = 2;
// What two closures may differ in besides their covariances: drift within the maps, the
// calibration, tilts.
constexpr double kCommon_m = 0.05, kCommon_rad = 5e-3;
constexpr double kElsewhereFactor = 5;  // times that

/// A place of the second map that shows what one of the first shows.
struct Alike {
  int first_node = 0, second_node = 0;
  UprightPose T_W1W2;  // between the odometries' worlds at the two places
  Matrix4d covariance;
  Vector3d p_W1;        // from the first place's body to the second one's
  UprightPose T_M1M2;   // and what it says of the maps
  Vector3d p_M1, p_M2;  // the bodies of the first and of the second place
};

PlaceQuery QueryOf(const PlaceRecord& place, const CameraModel& lens) {
  PlaceQuery query{lens, place.T_WB, place.T_BC, place.sigma_tilt_rad, {}};
  for (const RecordPoint& point : place.points) {
    for (std::size_t level = 0; level < kNumCornerLevels; ++level)
      query.corners.push_back(
          {point.px.cast<double>(), static_cast<int>(level), -1, point.descriptors[level]});
  }
  return query;
}

std::vector<Alike> FindAlike(const SavedMap& first, const SavedMap& second, int& num_compared) {
  const std::deque<PlaceRecord> places(first.places.begin(), first.places.end());
  const PlaceIndex index(places);
  ClosureChecker checker(kMinInliers);
  std::vector<CameraModel> lenses(second.lenses.begin(), second.lenses.end());
  std::vector<Alike> alike;
  for (const PlaceRecord& place : second.places) {
    const PlaceQuery query = QueryOf(place, lenses[place.session]);
    for (const int guess : index.Best(query.corners, kMostGuesses)) {
      ++num_compared;
      const ClosureCheck check =
          checker.Check(query, WithNeighbours(places, guess), ClosurePrediction());
      if (!check.is_closure()) continue;
      const UprightPose& T_M1W1 = first.graph.nodes[places[guess].node].T_MW;
      const UprightPose& T_M2W2 = second.graph.nodes[place.node].T_MW;
      alike.push_back({places[guess].node,
                       place.node,
                       check.T_WplaceWquery,
                       check.covariance,
                       check.T_WplaceWquery * place.T_WB.p - places[guess].T_WB.p,
                       T_M1W1 * check.T_WplaceWquery * T_M2W2.Inverse(),
                       T_M1W1 * places[guess].T_WB.p,
                       T_M2W2 * place.T_WB.p});
    }
  }
  return alike;
}

/// How far apart the maps are by the two, in what noise and drift allow.
double Apart(const Alike& a, const Alike& b) {
  const Matrix4d covariance = a.covariance + b.covariance;
  const double sigma_m = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
  const double yaw =
      std::abs(std::remainder(a.T_M1M2.yaw_rad - b.T_M1M2.yaw_rad, 2 * std::numbers::pi));
  return std::max(yaw / (3 * std::sqrt(covariance(0, 0)) + kCommon_rad),
                  (a.T_M1M2 * b.p_M2 - b.T_M1M2 * b.p_M2).norm() / (3 * sigma_m + kCommon_m));
}

bool Agree(const Alike& a, const Alike& b) {
  return Apart(a, b) < 1;
}

std::vector<Alike> AgreeingWith(const Alike& one, const std::vector<Alike>& alike) {
  std::vector<Alike> agreeing;
  std::ranges::copy_if(
      alike, std::back_inserter(agreeing), [&](const Alike& other) { return Agree(one, other); });
  return agreeing;
}

std::size_t NumPlaces(const std::vector<Alike>& alike) {
  std::set<int> nodes;
  for (const Alike& one : alike)
    nodes.insert(one.second_node);
  return nodes.size();
}

// The same poster may hang elsewhere, and looks the same from wherever it is seen alone, also to a
// body that hovers before it.
bool AreMoreThanOneView(const std::vector<Alike>& alike) {
  constexpr double kMoved_m = 0.1;
  const Alike& other = alike.front();
  return std::ranges::any_of(alike, [&](const Alike& one) {
    return (one.p_M1 - other.p_M1).norm() > kMoved_m && (one.p_M2 - other.p_M2).norm() > kMoved_m;
  });
}

/// The one that most places of the second map agree with.
const Alike* Best(const std::vector<Alike>& alike) {
  const Alike* best = nullptr;
  std::size_t most = 0;
  for (const Alike& one : alike) {
    const std::size_t num = NumPlaces(AgreeingWith(one, alike));
    if (num <= most) continue;
    most = num;
    best = &one;
  }
  return best;
}

bool HasRivals(const Alike& best, const std::vector<Alike>& alike) {
  const std::size_t most = NumPlaces(AgreeingWith(best, alike));
  return std::ranges::any_of(alike, [&](const Alike& other) {
    if (Apart(best, other) < kElsewhereFactor) return false;  // badly fitted, and no other part
    const std::size_t num = NumPlaces(AgreeingWith(other, alike));
    return num >= kMinElsewhere && 3 * num >= most;
  });
}

/// Both maps, where nothing but T_M1M2 ties them together yet.
SavedMap SideBySide(const SavedMap& first, const SavedMap& second, const UprightPose& T_M1M2) {
  const auto num_nodes = static_cast<int>(first.graph.nodes.size());
  MapGraph graph(first.graph);
  graph.AddSession(second.graph.nodes.front().p_W);
  SavedMap map = first;
  map.graph = graph.state();
  const auto num_edges = static_cast<int>(map.graph.edges.size());
  const int between = map.graph.nodes.back().edge_to_previous;
  map.graph.nodes.pop_back();
  for (GraphNode node : second.graph.nodes) {
    node.edge_to_previous = node.edge_to_previous < 0 ? between : node.edge_to_previous + num_edges;
    node.T_MW = T_M1M2 * node.T_MW;
    map.graph.nodes.push_back(node);
  }
  for (GraphEdge edge : second.graph.edges) {
    edge.first += num_nodes;
    edge.second += num_nodes;
    map.graph.edges.push_back(edge);
  }
  map.lenses.insert(map.lenses.end(), second.lenses.begin(), second.lenses.end());
  for (MapKeyframe keyframe : second.keyframes) {
    keyframe.session += first.num_sessions();
    map.keyframes.push_back(keyframe);
  }
  for (PlaceRecord place : second.places) {
    place.session += first.num_sessions();
    place.node += num_nodes;
    map.places.push_back(std::move(place));
  }
  return map;
}

/// Of places that share errors: together they are not worth what they would be each for itself.
GraphEdge EdgeOf(const Alike& one, std::size_t num_agreeing, int num_first) {
  constexpr double kOwn_m = 5e-3, kOwn_rad = 1e-3;  // of the calibration
  GraphEdge edge;
  edge.first = one.first_node;
  edge.second = one.second_node + num_first;
  edge.yaw_rad = one.T_W1W2.yaw_rad;
  edge.p_first = one.p_W1;
  edge.covariance = one.covariance;
  edge.covariance.diagonal().tail<3>().array() += kOwn_m * kOwn_m;
  edge.covariance(0, 0) += kOwn_rad * kOwn_rad;
  edge.covariance *= std::sqrt(static_cast<double>(num_agreeing));
  return edge;
}

}  // namespace

MapMerge MergeMaps(const SavedMap& first, const SavedMap& second) {
  MapMerge merge;
  const std::vector<Alike> alike = FindAlike(first, second, merge.num_compared);
  merge.num_alike = static_cast<int>(alike.size());
  const Alike* best = Best(alike);
  if (best == nullptr) return merge;
  const std::vector<Alike> agreeing = AgreeingWith(*best, alike);
  if (NumPlaces(agreeing) < kMinAgreeing) return merge;
  merge.is_ambiguous = HasRivals(*best, alike);
  if (merge.is_ambiguous || !AreMoreThanOneView(agreeing)) return merge;
  merge.is_found = true;
  merge.map = SideBySide(first, second, best->T_M1M2);
  MapGraph graph(merge.map.graph);
  for (const Alike& one : agreeing)
    graph.AddClosure(EdgeOf(one, NumPlaces(agreeing), static_cast<int>(first.graph.nodes.size())));
  graph.Optimize();
  const auto& edges = graph.edges();
  merge.num_closures = static_cast<int>(
      std::count_if(edges.end() - static_cast<std::ptrdiff_t>(agreeing.size()),
                    edges.end(),
                    [](const GraphEdge& edge) { return edge.weight >= kLeastBelievedWeight; }));
  merge.map.graph = graph.state();
  return merge;
}

}  // namespace facet
