// SPDX-License-Identifier: BSD-2-Clause
#include "april_corners_study.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include <Eigen/Eigenvalues>

#include "facet/geometry/plane_fit.h"

namespace facet {

namespace {

constexpr Duration kMaxImuGap{20'000'000};
// The recording's IMU ends 20 ms before its last frame.
constexpr Duration kMaxImuExtrapolation{30'000'000};
constexpr int kMinLandmarksOfFit = 8;

// Gives corners landmark ids that live until the corner is out of sight for a while.
class TrackBook {
 public:
  explicit TrackBook(int max_unseen_frames) : max_unseen_frames_(max_unseen_frames) {}

  FrameObservations Observe(const std::map<int, CornerObservation>& corners,
                            int frame,
                            bool with_right,
                            double pixel_sigma) {
    FrameObservations out;
    for (const auto& [corner, observation] : corners) {
      if (!observation.px_left) continue;
      FeatureObservation feature;
      feature.landmark = TrackOf(corner, frame);
      feature.px_left = *observation.px_left;
      if (with_right) feature.px_right = observation.px_right;
      feature.sigma_left_px = feature.sigma_right_px = pixel_sigma;
      out.features.push_back(feature);
    }
    return out;
  }

  // Cuts the tracks whose landmark has left the window, so that ids are not a map.
  void CutTracksOutside(const SlidingWindow& window) {
    std::unordered_set<LandmarkId> inside;
    for (const WindowLandmark& landmark : window.landmarks())
      inside.insert(landmark.id);
    std::erase_if(tracks_, [&](const auto& entry) { return !inside.contains(entry.second.id); });
  }

  int CornerOf(LandmarkId id) const { return corner_of_.at(id); }

 private:
  struct Track {
    LandmarkId id;
    int last_frame = 0;
  };

  LandmarkId TrackOf(int corner, int frame) {
    const auto it = tracks_.find(corner);
    if (it != tracks_.end() && frame - it->second.last_frame <= max_unseen_frames_) {
      it->second.last_frame = frame;
      return it->second.id;
    }
    const LandmarkId id{static_cast<std::int64_t>(corner_of_.size())};
    corner_of_[id] = corner;
    tracks_[corner] = {id, frame};
    return id;
  }

  int max_unseen_frames_;
  std::map<int, Track> tracks_;  // by corner
  std::unordered_map<LandmarkId, int> corner_of_;
};

// Columns and rows of six tags with four corners each.
int QuarterOf(const Vector3d& corner_G, const Vector3d& middle_G) {
  return (corner_G.x() > middle_G.x() ? 1 : 0) + (corner_G.y() > middle_G.y() ? 2 : 0);
}

Vector3d MiddleOf(const std::map<int, Vector3d>& corners_G) {
  Vector3d sum = Vector3d::Zero();
  for (const auto& [corner, p_G] : corners_G)
    sum += p_G;
  return sum / static_cast<double>(corners_G.size());
}

// Each quarter for 8 s, beginning 10 s into the recording.
std::map<int, CornerObservation> HideQuarter(std::map<int, CornerObservation> corners,
                                             double elapsed_s,
                                             const std::map<int, Vector3d>& corners_G) {
  const int hidden = static_cast<int>(std::floor((elapsed_s - 10) / 8));
  const Vector3d middle_G = MiddleOf(corners_G);
  std::erase_if(corners, [&](const auto& entry) {
    return QuarterOf(corners_G.at(entry.first), middle_G) == hidden;
  });
  return corners;
}

// The planes of the board and who lies on them, known from the board.
class BoardPlanes {
 public:
  BoardPlanes(const std::map<int, Vector3d>& corners_G, int num_planes)
      : corners_G_(corners_G), middle_G_(MiddleOf(corners_G)), num_planes_(num_planes) {}

  PlaneAssignments Assign(const MapSnapshot& snapshot, const TrackBook& tracks) {
    PlaneAssignments out;
    for (int k = 0; k < num_planes_; ++k) {
      std::vector<const LandmarkEstimate*> members;
      std::vector<Vector3d> points_W;
      for (const LandmarkEstimate& landmark : snapshot.landmarks) {
        const Vector3d& p_G = corners_G_.at(tracks.CornerOf(landmark.id));
        if (num_planes_ > 1 && QuarterOf(p_G, middle_G_) != k) continue;
        members.push_back(&landmark);
        points_W.push_back(landmark.p_W);
      }
      if (created_.count(k) == 0) {
        if (members.size() < kMinLandmarksOfPlane) continue;
        const PlaneFit fit = FitPlane(points_W);
        if (fit.extent_minor_m < kMinExtent_m) continue;
        out.created.push_back({PlaneId{k}, fit.plane, fit.centroid});
        if (!created_.empty())
          out.relations.push_back(
              {PlaneRelationKind::kCoplanar, PlaneId{*created_.begin()}, PlaneId{k}});
        created_.insert(k);
      }
      for (const LandmarkEstimate* landmark : members)
        out.attached.push_back({landmark->id, PlaneId{k}});
    }
    return out;
  }

 private:
  static constexpr std::size_t kMinLandmarksOfPlane = 12;
  static constexpr double kMinExtent_m = 0.05;
  const std::map<int, Vector3d>& corners_G_;
  Vector3d middle_G_;
  int num_planes_;
  std::set<int> created_;
};

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values)
    sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Median(std::vector<double> values) {
  return values.empty() ? 0 : Summarize(std::move(values)).median;
}

double RmsFromPlane(const std::vector<Vector3d>& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points)
    mean += p / static_cast<double>(points.size());
  Matrix3d scatter = Matrix3d::Zero();
  for (const Vector3d& p : points)
    scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter);
  const double smallest = std::max(eigen.eigenvalues()(0), 0.0);
  return std::sqrt(smallest / static_cast<double>(points.size()));
}

std::optional<BoardFit> FitBoard(const MapSnapshot& snapshot,
                                 const TrackBook& tracks,
                                 const std::map<int, Vector3d>& corners_G) {
  std::vector<Vector3d> points_W, points_G;
  for (const LandmarkEstimate& landmark : snapshot.landmarks) {
    points_W.push_back(landmark.p_W);
    points_G.push_back(corners_G.at(tracks.CornerOf(landmark.id)));
  }
  if (points_W.size() < kMinLandmarksOfFit) return std::nullopt;
  const TrajectoryAlignment T = AlignTrajectory(points_W, points_G, AlignmentKind::kSE3);
  std::vector<double> errors;
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    errors.push_back((T * points_W[i] - points_G[i]).norm());
  }
  return BoardFit{
      static_cast<int>(points_W.size()), RootMeanSquare(errors), RmsFromPlane(points_W)};
}

CostSummary SummarizeCost(std::vector<double> ms) {
  if (ms.empty()) return {};
  std::sort(ms.begin(), ms.end());
  const auto p99 = static_cast<std::size_t>(0.99 * static_cast<double>(ms.size() - 1));
  const ErrorStatistics s = Summarize(ms);
  return {s.mean, s.median, ms[p99]};
}

}  // namespace

AprilRun RunAprilCorners(const AprilRecording& recording, const AprilOptions& options) {
  const Calibration& calibration = recording.calibration;
  VioEstimator estimator(calibration.rig, calibration.imu_noise, options.estimator);
  TrackBook tracks(options.max_unseen_frames);
  BoardPlanes planes(recording.corners_G, options.num_planes);
  AprilRun run;
  std::vector<double> all_ms, keyframe_ms;
  std::optional<Timestamp> previous_t;
  for (const auto& [t, corners] : recording.frames) {
    const double elapsed_s = ToSeconds(t - recording.frames.begin()->first);
    if (t < recording.imu.first_stamp() || elapsed_s < options.start_s) continue;
    const int index = run.num_frames++;
    const bool is_keyframe = !estimator.is_initialised() || index % options.keyframe_every == 0;
    FrameObservations observations = tracks.Observe(
        options.hide_quarters ? HideQuarter(corners, elapsed_s, recording.corners_G) : corners,
        index,
        is_keyframe,
        options.pixel_sigma);
    observations.frame = FrameId{index};
    observations.t = t;
    observations.is_keyframe = is_keyframe;
    ImuInterval imu;
    if (previous_t) imu = recording.imu.Between(*previous_t, t, kMaxImuGap, kMaxImuExtrapolation);
    previous_t = t;

    StageTimes times;
    const EstimatorResult result = estimator.AddFrame(observations, imu, times);
    all_ms.push_back(times.Total());
    run.num_resets += result.was_reset ? 1 : 0;
    if (!result.has_state) continue;
    run.poses.push_back({t, result.state.T_WB});
    if (!is_keyframe) continue;
    keyframe_ms.push_back(times.Total());
    const MapSnapshot snapshot = estimator.Snapshot();
    const auto fit = FitBoard(snapshot, tracks, recording.corners_G);
    if (fit) run.fits.push_back(*fit);
    for (const PlaneEstimate& plane : snapshot.planes)
      run.planes_W.push_back(plane.plane_W);
    estimator.Assign(planes.Assign(snapshot, tracks));
    tracks.CutTracksOutside(estimator.window());
  }
  run.cost = {SummarizeCost(std::move(all_ms)), SummarizeCost(std::move(keyframe_ms))};
  return run;
}

AprilFigures EvaluateAprilCorners(const AprilRecording& recording, const AprilRun& run) {
  AprilFigures figures;
  figures.coverage = static_cast<double>(run.poses.size()) / std::max(1, run.num_frames);
  figures.trajectory = EvaluateTrajectory(run.poses, recording.truth);
  const Quaterniond q_GW = figures.trajectory.alignment.T_GW.q;
  std::vector<double> angles_deg;
  for (const PosePair& pair : Associate(run.poses, recording.truth).pairs) {
    const double angle = (q_GW * pair.T_WB.q).angularDistance(pair.T_GB.q);
    angles_deg.push_back(angle * 180 / std::numbers::pi);
  }
  figures.rotation_deg = Summarize(std::move(angles_deg));
  std::vector<double> plane_angles_deg;
  for (const Plane& plane : run.planes_W) {
    const double cosine = std::abs((q_GW * plane.n).z());
    plane_angles_deg.push_back(std::acos(std::min(cosine, 1.0)) * 180 / std::numbers::pi);
  }
  if (!plane_angles_deg.empty()) figures.plane_angle_deg = Summarize(std::move(plane_angles_deg));
  std::vector<double> rms, flatness;
  for (const BoardFit& fit : run.fits) {
    rms.push_back(fit.rms_m);
    flatness.push_back(fit.flatness_m);
  }
  figures.landmark_rms_m = Median(std::move(rms));
  figures.flatness_m = Median(std::move(flatness));
  return figures;
}

}  // namespace facet
