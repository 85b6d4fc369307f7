// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/place_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "facet/base/median.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr const char* kClosureTakenBack = "taken back";
constexpr int kMostCandidates = 3;
constexpr double kMinSeenShare = 0.3;
constexpr double kKeepInterval_s = 1;
constexpr double kStampNoise_s = 1e-3;
constexpr double kAgreeWithin_s = 12;  // closures that confirm each other
constexpr std::size_t kMinAgreeing = 3;

// What two fits may differ in besides their covariances: the calibration, and tilts.
constexpr double kCommonError_m = 0.01, kCommonError_rad = 2e-3;

/// Variances of a turn about the axes of the world; the estimator states them in the body.
Vector3d TurnVariance(const KeyframeView& view) {
  return view.T_WB.R().cwiseAbs2() * view.sigma_theta.cwiseAbs2();
}

double SigmaTilt(const KeyframeView& view) {
  constexpr double kLeast_rad = 1e-3;  // what calibration and gravity leave
  return std::max(kLeast_rad, std::sqrt(TurnVariance(view).head<2>().maxCoeff()));
}

/// What the odometry has drifted from one keyframe to another: what its covariance has grown by.
Matrix4d Drift(const KeyframeView& from, const KeyframeView& to) {
  // A share of the way that is always allowed: the stated covariance is not exact, and shrinks
  // where planes are found again.
  constexpr double kLeastShare = 5e-4, kLeast_m = 2e-4, kLeast_rad = 5e-5;
  const double way_m = (to.T_WB.p - from.T_WB.p).norm();
  const double least_m = kLeast_m + kLeastShare * way_m;
  Vector<4> variance;
  const double turned = TurnVariance(to).z() - TurnVariance(from).z();
  variance(0) = std::max(kLeast_rad * kLeast_rad, turned);
  variance.tail<3>() =
      (to.sigma_p.cwiseAbs2() - from.sigma_p.cwiseAbs2()).cwiseMax(least_m * least_m);
  return variance.asDiagonal();
}

Vector3d UpInCamera(const KeyframeView& view) {
  return (view.T_WB * view.T_BC).q.conjugate() * Vector3d::UnitZ();
}

RecordPatch CutPatch(const ImageLevel& image, const Eigen::Vector2f& at) {
  RecordPatch patch;
  const int x0 = static_cast<int>(at.x()) - 5, y0 = static_cast<int>(at.y()) - 5;
  patch.x = at.x() - static_cast<float>(x0);
  patch.y = at.y() - static_cast<float>(y0);
  for (int y = 0; y < RecordPatch::kSide; ++y) {
    for (int x = 0; x < RecordPatch::kSide; ++x) {
      const int column = std::clamp(x0 + x, 0, image.width - 1);
      const int row = std::clamp(y0 + y, 0, image.height - 1);
      patch.grey[y * RecordPatch::kSide + x] = image.data[row * image.step + column];
    }
  }
  return patch;
}

}  // namespace

PlaceMap::PlaceMap(const StereoRig& rig, const LoopOptions& options)
    : camera_(rig.cameras[0]),
      focal_baseline_(camera_.mean_focal_px() * rig.baseline_m()),
      options_(options),
      corners_(camera_),
      checker_(options.min_inliers) {}

PlaceMap::PlaceMap(const StereoRig& rig, const LoopOptions& options, const SavedMap& known)
    : PlaceMap(rig, options) {
  if (known.places.empty()) return;
  graph_ = MapGraph(known.graph);
  keyframes_ = known.keyframes;
  known_lenses_ = known.lenses;
  places_.assign(known.places.begin(), known.places.end());
  SetLenses(known.lenses, places_);
  index_.emplace(places_);
  session_ = known.num_sessions();
  first_own_node_ = first_sought_node_ = graph_.num_nodes();
  num_places_before_ = num_places();
  is_localised_ = false;
}

double PlaceMap::Interval_s(Timestamp t) const {
  constexpr double kLost_s = 0.1, kHurried_s = 20, kPatient_s = 2;
  if (!index_) return options_.query_interval_s;
  const bool is_hurried = !search_began_ || ToSeconds(t - *search_began_) < kHurried_s;
  return is_hurried ? std::min(kLost_s, options_.query_interval_s)
                    : std::max(kPatient_s, options_.query_interval_s);
}

bool PlaceMap::IsWanted(Timestamp t) const {
  return !last_query_ || ToSeconds(t - *last_query_) >= Interval_s(t) - kStampNoise_s;
}

bool PlaceMap::IsLookedFor(Timestamp t) const {
  return index_ && last_look_ && ToSeconds(t - *last_look_) >= Interval_s(t) - kStampNoise_s;
}

void PlaceMap::Look(const KeyframeView& view) {
  if (!IsLookedFor(view.t) || view.left.empty() || view.segment != last_query_segment_) return;
  pyramid_.Build(view.left, 2);
  LookFor(view);
  pyramid_.Clear();  // it refers to the image
}

// Where the last keyframe was recognised from nearly the same pose everything has been said.
bool PlaceMap::Hovers(const KeyframeView& view) const {
  constexpr double kMoved_m = 0.1, kTurned_rad = 0.05, kLongest_s = 5;
  if (!is_known_well_ || view.segment != last_query_segment_) return false;
  if (closures_.empty() || closures_.back().t != *last_query_) return false;
  if (closures_.back().verdict != kClosureAccepted) return false;
  if (ToSeconds(view.t - *last_query_) > kLongest_s) return false;
  const SE3 moved = last_query_T_WB_.Inverse() * view.T_WB;
  return moved.p.norm() < kMoved_m && LogSO3(moved.q).norm() < kTurned_rad;
}

void PlaceMap::Add(const KeyframeView& view) {
  if (!IsWanted(view.t) || view.left.empty() || Hovers(view)) return;
  if (last_query_ && view.segment != last_query_segment_) BeginSearch(view);
  if (!search_began_) search_began_ = view.t;
  EndLongSearch(view.t);
  last_query_ = view.t;
  last_query_T_WB_ = view.T_WB;
  last_query_segment_ = view.segment;
  is_known_well_ = false;
  pyramid_.Build(view.left, 2);
  LookFor(view);
  Keep(view);
  pyramid_.Clear();  // it refers to the image
}

void PlaceMap::LookFor(const KeyframeView& view) {
  last_look_ = view.t;
  const std::vector<int> candidates = Candidates(view);
  if (!candidates.empty() || index_) {
    query_ = {view.camera,
              view.T_WB,
              view.T_BC,
              SigmaTilt(view),
              corners_.Detect(view.left, UpInCamera(view)),
              &pyramid_};
    std::size_t num_expected = 0, num_seen = 0;  // of the places that a finding is about
    for (const int place : candidates) {
      const auto places = WithNeighbours(places_, place);
      const ClosureCheck check = checker_.Check(query_, places, Predict(places_[place], view));
      Consider(check, place, view);
      if (IsOfThisPart(place)) continue;
      ++num_expected;
      num_seen += check.is_closure() ? 1 : 0;
    }
    if (index_) CompareByAppearance(view);
    BelieveWhatAgrees();
    JudgeFinding(num_expected, num_seen, view.t);
  }
  if (graph_.num_nodes() > first_own_node_) T_MW_ = graph_.T_MW(graph_.num_nodes() - 1);
}

// After a loss nothing but gravity is known for sure. Who is looked for already goes on being so:
// what came before this loss is in no map either.
void PlaceMap::BeginSearch(const KeyframeView& view) {
  if (places_.empty()) return;
  search_began_ = view.t;
  if (index_) return;
  index_.emplace(places_);
  finding_.reset();  // it was about another part
  first_sought_node_ = graph_.num_nodes();
  num_places_before_ = num_places();
}

/// After a loss the odometry's own claim has to do if nothing is found for long.
void PlaceMap::EndLongSearch(Timestamp t) {
  constexpr double kLongest_s = 60;
  if (!index_ || !is_localised_ || ToSeconds(t - *search_began_) < kLongest_s) return;
  index_.reset();
  is_ambiguous_ = false;
  DropByAppearance();
}

void PlaceMap::DropByAppearance() {
  for (const Pending& one : pending_) {
    ClosureRecord& record = closures_[one.closure];
    if (one.is_by_appearance && record.edge < 0) record.verdict = "no others agreed";
  }
  std::erase_if(pending_, [](const Pending& one) { return one.is_by_appearance; });
}

/// Whether it is of the part of the run that is looked for.
bool PlaceMap::IsOfThisPart(int place) const {
  return place >= num_places_before_;
}

void PlaceMap::CompareByAppearance(const KeyframeView& view) {
  constexpr std::size_t kMostGuesses = 10;
  for (const int place : index_->Best(query_.corners, kMostGuesses)) {
    const ClosureCheck check =
        checker_.Check(query_, WithNeighbours(places_, place), ClosurePrediction());
    if (check.is_closure()) Consider(check, place, view);  // guesses that are none are no news
  }
}

// Places that the keyframe should see, if the map is right about where both are: best first.
std::vector<int> PlaceMap::Candidates(const KeyframeView& view) const {
  std::vector<std::pair<double, int>> found;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const PlaceRecord& place = places_[i];
    // Where the others are is not known well enough.
    if (index_ && !IsOfThisPart(static_cast<int>(i))) continue;
    if (place.session == session_ && ToSeconds(view.t - place.t) < options_.min_age_s) continue;
    const SE3 T_MW_place = graph_.T_MW(place.node).ToSE3();
    const SE3 T_WC = (T_MW_place.Inverse() * T_MW_.ToSE3()) * view.T_WB * view.T_BC;
    const double share = SeenShare(place, T_WC.Inverse(), T_WC);
    if (share >= kMinSeenShare) found.emplace_back(-share, static_cast<int>(i));
  }
  std::sort(found.begin(), found.end());
  std::vector<int> candidates;
  for (const auto& [share, place] : found) {
    if (static_cast<int>(candidates.size()) == kMostCandidates) break;
    candidates.push_back(place);
  }
  return candidates;
}

double PlaceMap::SeenShare(const PlaceRecord& place, const SE3& T_CW, const SE3& T_WC) const {
  constexpr std::size_t kEvery = 4;
  constexpr double kMaxRatio = 1.7, kLeastCosine = 0.87;
  const SE3 T_WCplace = place.T_WC();
  int num_seen = 0, num = 0;
  for (std::size_t i = 0; i < place.points.size(); i += kEvery) {
    ++num;
    const Vector3d p_place = place.points[i].p_C.cast<double>();
    const Vector3d p_C = T_CW * (T_WCplace * p_place);
    if (p_C.norm() < kMinDistance_m) continue;
    const double ratio = p_C.norm() / p_place.norm();
    if (ratio > kMaxRatio || ratio < 1 / kMaxRatio) continue;
    // Seen from too different a side, it looks different.
    if ((T_WC.q * p_C).dot(T_WCplace.q * p_place) < kLeastCosine * p_C.norm() * p_place.norm())
      continue;
    const auto px = camera_.Project(p_C);
    if (px && camera_.IsInside(*px, 0)) ++num_seen;
  }
  return num > 0 ? static_cast<double>(num_seen) / num : 0;
}

ClosurePrediction PlaceMap::Predict(const PlaceRecord& place, const KeyframeView& view) const {
  const UprightPose T_WplaceWquery = graph_.T_MW(place.node).Inverse() * T_MW_;
  const double angle =
      3 * (view.sigma_p.maxCoeff() / place.median_distance_m + view.sigma_theta.maxCoeff()) + 0.1;
  return {T_WplaceWquery, angle};
}

int PlaceMap::NodeOf(const KeyframeView& view) {
  const bool is_first = graph_.num_nodes() == first_own_node_;
  if (!is_first && keyframes_.back().frame == view.frame) return graph_.num_nodes() - 1;
  const int node = is_first ? graph_.AddSession(view.T_WB.p)
                            : graph_.AddNode(view.T_WB.p, Drift(last_node_view_, view));
  keyframes_.push_back({view.frame, view.t, view.segment, session_});
  last_node_view_ = view;
  last_node_view_.left = cv::Mat();
  last_node_view_.points.clear();
  return node;
}

void PlaceMap::Consider(const ClosureCheck& check, int place, const KeyframeView& view) {
  ClosureRecord record{view.t,
                       places_[place].t,
                       check.num_matches,
                       check.num_inliers,
                       check.num_visible,
                       check.T_WplaceWquery,
                       std::sqrt(check.covariance.diagonal().tail<3>().maxCoeff()),
                       std::sqrt(check.covariance(0, 0)),
                       check.is_closure() ? "waiting for others" : check.refusal,
                       -1};
  closures_.push_back(record);
  if (!check.is_closure()) return;
  const int node = NodeOf(view);
  Matrix4d covariance = check.covariance;
  const double apart_m = (check.T_WplaceWquery * view.T_WB.p - places_[place].T_WB.p).norm();
  // Points lie too far or too near by an error of disparity that all have in common, and the way
  // between the views is too long or too short by the same share; what is left of that is noise.
  constexpr double kOwnDisparity_px = 0.04, kCommon_m = 3e-3, kCommon_rad = 1e-3;
  const double stretch_per_px = places_[place].median_distance_m / focal_baseline_;
  const double common_m = kCommon_m + kOwnDisparity_px * stretch_per_px * apart_m;
  covariance.diagonal().tail<3>().array() += common_m * common_m;
  covariance(0, 0) += kCommon_rad * kCommon_rad;
  pending_.push_back({closures_.size() - 1,
                      places_[place].node,
                      node,
                      check.T_WplaceWquery,
                      covariance,
                      stretch_per_px,
                      view.T_WB.p,
                      check.T_WplaceWquery * view.T_WB.p - places_[place].T_WB.p,
                      view.t,
                      index_ && !IsOfThisPart(place)});
  const SE3 T_moved = places_[place].T_WB.Inverse() * check.T_WplaceWquery.ToSE3() * view.T_WB;
  constexpr double kSameShare = 0.15, kSameAngle_rad = 0.35;
  if (T_moved.p.norm() < kSameShare * places_[place].median_distance_m &&
      2 * std::acos(std::min(1.0, std::abs(T_moved.q.w()))) < kSameAngle_rad)
    is_known_well_ = true;
}

// Whether both say the same about where the map is, at the younger keyframe.
bool PlaceMap::Agree(const Pending& a, const Pending& b) const {
  const UprightPose by_a = graph_.T_MW(a.place_node) * a.T_WplaceWquery;
  const UprightPose by_b = graph_.T_MW(b.place_node) * b.T_WplaceWquery;
  const Vector3d& p_W = a.t < b.t ? b.p_W : a.p_W;
  const Matrix4d covariance = a.covariance + b.covariance;
  const double yaw = std::abs(std::remainder(by_a.yaw_rad - by_b.yaw_rad, 2 * std::numbers::pi));
  const double sigma_m = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
  return yaw < 3 * std::sqrt(covariance(0, 0)) + kCommonError_rad &&
         (by_a * p_W - by_b * p_W).norm() < 3 * sigma_m + kCommonError_m;
}

/// The nodes of those that say the same, its own first; or only of those found by appearance.
std::vector<int> PlaceMap::AgreeingKeyframes(const Pending& one, bool by_appearance) const {
  std::vector<int> keyframes = {one.query_node};
  for (const Pending& other : pending_) {
    if (by_appearance && !other.is_by_appearance) continue;
    if (std::find(keyframes.begin(), keyframes.end(), other.query_node) == keyframes.end() &&
        Agree(one, other))
      keyframes.push_back(other.query_node);
  }
  return keyframes;
}

// A camera that stands still sees the same thing three times, and the same poster may hang
// elsewhere.
bool PlaceMap::IsMoreThanOneView(const Pending& one) const {
  constexpr double kMoved_m = 0.1;
  return std::any_of(pending_.begin(), pending_.end(), [&](const Pending& other) {
    return other.is_by_appearance && Agree(one, other) &&
           (other.place_node != one.place_node || (other.p_W - one.p_W).norm() > kMoved_m);
  });
}

// Two rooms that look alike are both found: then the run is in neither, until one of them is
// contradicted.
void PlaceMap::FindInMap() {
  constexpr std::size_t kMinElsewhere = 2;
  const Pending* best = nullptr;
  std::size_t most = 0;
  is_ambiguous_ = false;
  for (const Pending& one : pending_) {
    if (!one.is_by_appearance) continue;
    const std::size_t num = AgreeingKeyframes(one, true).size();
    if (num > most) {
      most = num;
      best = &one;
    }
  }
  if (most < kMinAgreeing) return;
  is_ambiguous_ = std::any_of(pending_.begin(), pending_.end(), [&](const Pending& other) {
    if (!other.is_by_appearance || Agree(*best, other)) return false;
    const std::size_t num = AgreeingKeyframes(other, true).size();
    return num >= kMinElsewhere && 3 * num >= most;
  });
  if (is_ambiguous_ || !IsMoreThanOneView(*best)) return;
  T_MW_ = graph_.T_MW(best->place_node) * best->T_WplaceWquery;
  const UprightPose moved = T_MW_ * graph_.T_MW(best->query_node).Inverse();
  graph_.Move(first_sought_node_, moved);
  finding_ = Finding{is_localised_, moved};
  if (!is_localised_) localised_ = pending_.back().t;
  is_localised_ = true;
  index_.reset();
}

// Where a place is seen that was predicted the finding is right. A part of the map that looks the
// same as where the run is has other surroundings.
void PlaceMap::JudgeFinding(std::size_t num_expected, std::size_t num_seen, Timestamp t) {
  constexpr int kMostInVain = 10;
  if (!finding_ || index_ || num_expected == 0) return;
  if (num_seen > 0) return finding_.reset();
  if (++finding_->num_in_vain >= kMostInVain) TakeFindingBack(t);
}

// The closures within the part stay, as do all of its places.
void PlaceMap::TakeFindingBack(Timestamp t) {
  DropByAppearance();
  const std::vector<int> numbers = graph_.RemoveClosuresAcross(first_sought_node_);
  for (ClosureRecord& record : closures_) {
    if (record.edge < 0) continue;
    record.edge = numbers[record.edge];
    if (record.edge < 0) record.verdict = kClosureTakenBack;
  }
  graph_.Move(first_sought_node_, finding_->moved.Inverse());
  graph_.Optimize();
  index_.emplace(places_, static_cast<std::size_t>(num_places_before_));
  search_began_ = t;
  is_localised_ = finding_->was_localised;
  if (!is_localised_) localised_.reset();
  finding_.reset();
}

// A closure becomes an edge when enough others, from other keyframes, say the same.
void PlaceMap::BelieveWhatAgrees() {
  if (pending_.empty()) return;
  while (ToSeconds(pending_.back().t - pending_.front().t) > kAgreeWithin_s) {
    ClosureRecord& record = closures_[pending_.front().closure];
    if (record.edge < 0) record.verdict = "no others agreed";
    pending_.pop_front();
  }
  if (index_) FindInMap();
  bool has_new = false;
  for (const Pending& one : pending_) {
    ClosureRecord& record = closures_[one.closure];
    if (record.edge >= 0 || (one.is_by_appearance && index_)) continue;
    const std::vector<int> keyframes = AgreeingKeyframes(one, false);
    if (keyframes.size() < kMinAgreeing) continue;
    record.edge = static_cast<int>(graph_.edges().size());
    record.verdict = kClosureAccepted;
    // They share errors, so that together they are not worth what they would be each for itself.
    GraphEdge edge;
    edge.first = one.place_node;
    edge.second = one.query_node;
    edge.yaw_rad = one.T_WplaceWquery.yaw_rad;
    edge.p_first = one.p_place;
    edge.covariance = std::sqrt(static_cast<double>(keyframes.size())) * one.covariance;
    edge.stretch_per_px = one.stretch_per_px;
    graph_.AddClosure(edge);
    has_new = true;
  }
  if (has_new) graph_.Optimize();
}

void PlaceMap::Keep(const KeyframeView& view) {
  constexpr std::size_t kFewestPoints = 30;
  if (last_kept_ && ToSeconds(view.t - *last_kept_) < kKeepInterval_s - kStampNoise_s) return;
  const int node = NodeOf(view);
  if (is_known_well_ || view.points.size() < kFewestPoints) return;
  last_kept_ = view.t;
  PlaceRecord place;
  place.node = node;
  place.frame = view.frame;
  place.t = view.t;
  place.segment = view.segment;
  place.session = session_;
  place.T_WB = view.T_WB;
  place.T_BC = view.T_BC;
  place.sigma_tilt_rad = SigmaTilt(view);
  KeepPoints(view, place);
  places_.push_back(std::move(place));
}

// Those that have a descriptor on every level.
void PlaceMap::KeepPoints(const KeyframeView& view, PlaceRecord& place) {
  std::vector<Vector2d> pixels;
  for (const PlacePoint& point : view.points)
    pixels.push_back(point.px);
  std::vector<int> levels(view.points.size(), 0);
  std::vector<RecordPoint> points(view.points.size());
  for (const UprightCorner& corner : corners_.Describe(view.left, UpInCamera(view), pixels)) {
    ++levels[corner.source];
    points[corner.source].descriptors[corner.level] = corner.descriptor;
  }
  std::vector<double> distances_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (levels[i] != kNumCornerLevels) continue;
    points[i].px = view.points[i].px.cast<float>();
    for (int level = 0; level < 2; ++level)
      points[i].patches[level] = CutPatch(pyramid_.level(level), points[i].px / (1 << level));
    points[i].p_C = view.points[i].p_C.cast<float>();
    points[i].sigma_depth_m = static_cast<float>(view.points[i].sigma_depth_m);
    place.points.push_back(points[i]);
    place.landmarks.push_back(view.points[i].landmark);
    distances_m.push_back(points[i].p_C.norm());
  }
  place.median_distance_m = Median(distances_m).value_or(1);
}

void PlaceMap::Refine(const MapSnapshot& snapshot) {
  if (snapshot.keyframes.empty()) return;
  // Keyframes need not leave the window oldest first.
  const auto is_done = [&](const PlaceRecord& place) {
    return place.session != session_ ||
           (place.landmarks.empty() && place.t < snapshot.keyframes.front().t);
  };
  for (auto place = places_.rbegin(); place != places_.rend() && !is_done(*place); ++place) {
    if (place->landmarks.empty()) continue;
    const auto keyframe = std::find_if(snapshot.keyframes.begin(),
                                       snapshot.keyframes.end(),
                                       [&](const KeyframePose& k) { return k.id == place->frame; });
    if (keyframe == snapshot.keyframes.end()) {
      place->landmarks.clear();
      place->landmarks.shrink_to_fit();
      continue;
    }
    place->T_WB = keyframe->T_WB;
    const SE3 T_CW = place->T_WC().Inverse();
    for (std::size_t i = 0; i < place->points.size(); ++i) {
      const LandmarkEstimate* landmark = FindLandmark(snapshot, place->landmarks[i]);
      if (landmark == nullptr) continue;
      place->points[i].p_C = (T_CW * landmark->p_W).cast<float>();
      place->points[i].sigma_depth_m = static_cast<float>(landmark->sigma_depth_m);
    }
  }
}

void PlaceMap::Smooth(FrameId frame, const SE3& T_WB) {
  const auto node = std::lower_bound(keyframes_.begin() + first_own_node_,
                                     keyframes_.end(),
                                     frame,
                                     [](const MapKeyframe& n, FrameId f) { return n.frame < f; });
  if (node == keyframes_.end() || node->frame != frame) return;
  graph_.MoveNode(static_cast<int>(node - keyframes_.begin()), T_WB.p);
}

std::vector<MapCorrection> PlaceMap::Corrections() const {
  std::vector<MapCorrection> corrections;
  for (int i = first_own_node_; i < graph_.num_nodes(); ++i)
    corrections.push_back({keyframes_[i].t, keyframes_[i].segment, graph_.T_MW(i)});
  return corrections;
}

SavedMap PlaceMap::Saved() const {
  SavedMap saved{known_lenses_, graph_.state(), keyframes_, {}};
  const bool has_own = graph_.num_nodes() > first_own_node_;
  if (is_localised_)
    saved.lenses.push_back((has_own ? last_node_view_.camera : camera_).intrinsics());
  const int num_places_known = index_ ? num_places_before_ : num_places();
  for (int i = 0; i < num_places_known; ++i) {
    saved.places.push_back(places_[i]);
    saved.places.back().landmarks.clear();
    saved.places.back().landmarks.shrink_to_fit();
    saved.places.back().lens.reset();
  }
  if (!index_) return saved;
  saved.graph.nodes.resize(static_cast<std::size_t>(first_sought_node_));
  saved.keyframes.resize(static_cast<std::size_t>(first_sought_node_));
  // From the end: the edges between neighbours that stay keep their numbers.
  std::erase_if(saved.graph.edges,
                [&](const GraphEdge& edge) { return edge.second >= first_sought_node_; });
  return saved;
}

std::vector<ClosureRecord> PlaceMap::Closures() const {
  std::vector<ClosureRecord> closures = closures_;
  for (ClosureRecord& record : closures) {
    if (record.edge >= 0 && graph_.edges()[record.edge].weight < kLeastBelievedWeight)
      record.verdict = kClosureTakenBack;
  }
  return closures;
}

std::size_t PlaceMap::memory_bytes() const {
  std::size_t bytes = index_ ? index_->memory_bytes() : 0;
  for (const PlaceRecord& place : places_)
    bytes += sizeof(PlaceRecord) + place.points.capacity() * sizeof(RecordPoint);
  bytes +=
      keyframes_.capacity() * sizeof(MapKeyframe) + closures_.capacity() * sizeof(ClosureRecord);
  return bytes + graph_.edges().capacity() * sizeof(GraphEdge);
}

}  // namespace facet
