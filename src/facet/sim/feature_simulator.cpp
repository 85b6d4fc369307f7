// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/feature_simulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "facet/base/check.h"
#include "facet/calibration/lens_modes.h"

namespace facet {

namespace {

// Nearer points have no place in a stereo front end.
constexpr double kNearest_m = 0.25;

// How many lost points are remembered for redetection.
constexpr std::size_t kMaxLost = 2000;

Vector2d NoisyPixel(const Vector2d& px, const FeatureSimulatorOptions& options, Rng& rng) {
  const double sigma = options.add_pixel_noise ? options.pixel_sigma : 0.0;
  const double x = rng.Normal(), y = rng.Normal();
  Vector2d noise = sigma * Vector2d(x, y);
  if (rng.Uniform() < options.outlier_share) {
    const double smallest = 3 * options.pixel_sigma;
    const double size = rng.Uniform(smallest, std::max(smallest, options.outlier_px));
    const double angle = rng.Uniform(0, 2 * std::numbers::pi);
    noise += size * Vector2d(std::cos(angle), std::sin(angle));
  }
  return px + noise;
}

/// Square cells over the left image, about as many as tracks are wanted.
class CellGrid {
 public:
  CellGrid(const CameraModel& camera, int max_tracks)
      : size_px_(std::sqrt(static_cast<double>(camera.width()) * camera.height() /
                           std::max(1, max_tracks))),
        cols_(static_cast<int>(std::ceil(camera.width() / size_px_))),
        rows_(static_cast<int>(std::ceil(camera.height() / size_px_))) {}

  int size() const { return cols_ * rows_; }
  int IndexOf(const Vector2d& px) const {
    return std::clamp(static_cast<int>(px.y() / size_px_), 0, rows_ - 1) * cols_ +
           std::clamp(static_cast<int>(px.x() / size_px_), 0, cols_ - 1);
  }
  Vector2d RandomPixel(int cell, Rng& rng) const {
    const double x = rng.Uniform(), y = rng.Uniform();
    return {(cell % cols_ + x) * size_px_, (cell / cols_ + y) * size_px_};
  }

 private:
  double size_px_;
  int cols_, rows_;
};

/// Keeps tracks alive from frame to frame as a front end does.
class TrackSimulator {
 public:
  TrackSimulator(const StereoRig& rig,
                 const RoomScene& scene,
                 const FeatureSimulatorOptions& options,
                 Rng& rng)
      : rig_(rig),
        beside_model_(FieldsOf(rig)),
        scene_(scene),
        options_(options),
        rng_(rng),
        grid_(rig.cameras[0], options.max_tracks) {}

  std::vector<FeatureObservation> Observe(const SE3& T_WB, bool is_keyframe, SimulatedRun& run) {
    DropTracks(T_WB);
    if (is_keyframe) StartTracks(T_WB, run);
    std::vector<FeatureObservation> observations;
    observations.reserve(tracks_.size());
    for (const Track& track : tracks_) {
      FeatureObservation observation;
      observation.landmark = track.id;
      observation.px_left = NoisyPixel(track.px_left, options_, rng_) + track.error_px[0];
      observation.sigma_left_px = std::hypot(options_.pixel_sigma, options_.slide_sigma_px);
      observation.sigma_right_px = std::hypot(observation.sigma_left_px, options_.match_sigma_px);
      if (is_keyframe || options_.right_on_every_frame) {
        const auto px_right = See(1, T_WB, track.point.p_W);
        if (px_right)
          observation.px_right = NoisyPixel(*px_right, options_, rng_) + track.error_px[1];
      }
      observations.push_back(observation);
    }
    return observations;
  }

 private:
  struct Track {
    LandmarkId id;
    TrueLandmark point;
    Vector2d px_left = Vector2d::Zero();                                   // exact
    std::array<Vector2d, 2> error_px{Vector2d::Zero(), Vector2d::Zero()};  // for its whole life
  };

  /// Pixel of a point in camera c, if it is inside the image and nothing is in front of it.
  std::optional<Vector2d> See(int c, const SE3& T_WB, const Vector3d& p_W) const {
    const SE3 T_WC = T_WB * rig_.T_BC[c];
    const Vector3d p_C = T_WC.Inverse() * p_W;
    if (p_C.norm() < kNearest_m) return std::nullopt;
    auto px = rig_.cameras[c].Project(p_C);
    if (px) *px += beside_model_[static_cast<std::size_t>(c)].At(*px);
    if (!px || !rig_.cameras[c].IsInside(*px, options_.border_px)) return std::nullopt;
    if (!scene_.IsVisible(T_WC.p, p_W)) return std::nullopt;
    return px;
  }

  void DropTracks(const SE3& T_WB) {
    const double survival = std::exp(-1 / (options_.frame_rate_hz * options_.mean_track_life_s));
    std::vector<Track> kept;
    for (Track& track : tracks_) {
      const bool survives = rng_.Uniform() < survival;
      const auto px = survives ? See(0, T_WB, track.point.p_W) : std::nullopt;
      if (px) {
        track.px_left = *px;
        kept.push_back(track);
      } else {
        lost_.push_back(track.point);
      }
    }
    tracks_ = std::move(kept);
    while (lost_.size() > kMaxLost)
      lost_.pop_front();
  }

  /// Starts a track in every empty cell, in random order, up to the allowed number.
  void StartTracks(const SE3& T_WB, SimulatedRun& run) {
    std::vector<bool> is_taken(grid_.size(), false);
    for (const Track& track : tracks_)
      is_taken[grid_.IndexOf(track.px_left)] = true;
    std::vector<int> cells;
    for (int cell = 0; cell < grid_.size(); ++cell) {
      if (!is_taken[cell]) cells.push_back(cell);
    }
    for (int i = static_cast<int>(cells.size()) - 1; i > 0; --i) {
      std::swap(cells[i], cells[rng_.Index(i + 1)]);
    }
    const auto lost_in_cell = LostPointsInView(T_WB);
    for (const int cell : cells) {
      if (static_cast<int>(tracks_.size()) >= options_.max_tracks) return;
      const auto lost = lost_in_cell.find(cell);
      const bool again = rng_.Uniform() < options_.redetected_share && lost != lost_in_cell.end();
      if (again) {
        StartTrack(T_WB, lost->second, run);
      } else if (const auto point = NewPoint(T_WB, cell)) {
        StartTrack(T_WB, *point, run);
      }
    }
  }

  void StartTrack(const SE3& T_WB, const TrueLandmark& point, SimulatedRun& run) {
    const auto px = See(0, T_WB, point.p_W);
    if (!px) return;
    const LandmarkId id{next_id_++};
    tracks_.push_back({id, point, *px});
    run.landmarks.emplace(id, point);
    if (!options_.add_pixel_noise) return;
    std::array<Vector2d, 2>& error_px = tracks_.back().error_px;
    error_px[0] = LastingError(options_.slide_sigma_px);
    error_px[1] = error_px[0] + LastingError(options_.match_sigma_px);
  }

  Vector2d LastingError(double sigma_px) const {
    if (sigma_px <= 0) return Vector2d::Zero();  // without a number of the sequence
    const double x = rng_.Normal(), y = rng_.Normal();
    return sigma_px * Vector2d(x, y);
  }

  /// The oldest lost point in view in each cell.
  std::unordered_map<int, TrueLandmark> LostPointsInView(const SE3& T_WB) const {
    std::unordered_map<int, TrueLandmark> result;
    for (const TrueLandmark& point : lost_) {
      const auto px = See(0, T_WB, point.p_W);
      if (px) result.emplace(grid_.IndexOf(*px), point);
    }
    return result;
  }

  /// The point of the surface that a random pixel of the cell shows.
  std::optional<TrueLandmark> NewPoint(const SE3& T_WB, int cell) const {
    const auto bearing_C = rig_.cameras[0].Unproject(grid_.RandomPixel(cell, rng_));
    if (!bearing_C) return std::nullopt;
    const SE3 T_WC = T_WB * rig_.T_BC[0];
    const auto hit = scene_.CastRay(T_WC.p, T_WC.q * *bearing_C);
    if (!hit) return std::nullopt;
    return TrueLandmark{hit->p_W + Relief(hit->surface), hit->surface};
  }

  Vector3d Relief(PlaneId surface) const {
    if (options_.roughness_m <= 0) return Vector3d::Zero();
    const Vector3d& n_W = scene_.surfaces()[static_cast<std::size_t>(surface.value)].n_W;
    return rng_.Uniform(0, std::sqrt(12.0) * options_.roughness_m) * n_W;
  }

  const StereoRig& rig_;
  LensFields beside_model_;
  const RoomScene& scene_;
  const FeatureSimulatorOptions& options_;
  Rng& rng_;
  CellGrid grid_;
  std::vector<Track> tracks_;
  std::deque<TrueLandmark> lost_;
  std::int64_t next_id_ = 0;
};

std::vector<Vector3d> PathOf(const SplineTrajectory& trajectory, Timestamp begin, Timestamp end) {
  std::vector<Vector3d> path_W;
  for (Timestamp t = begin; t <= end; t = t + FromSeconds(0.1)) {
    path_W.push_back(trajectory.At(t).state.T_WB.p);
  }
  path_W.push_back(trajectory.At(end).state.T_WB.p);
  return path_W;
}

/// True bias at t, between the samples around it.
ImuBias BiasAt(const SimulatedImu& imu, Timestamp t) {
  const auto next = std::lower_bound(
      imu.samples.begin(), imu.samples.end(), t, [](const ImuSample& s, Timestamp stamp) {
        return s.t < stamp;
      });
  const std::size_t j = std::min<std::size_t>(next - imu.samples.begin(), imu.samples.size() - 1);
  if (j == 0) return imu.biases.front();
  const double u =
      ToSeconds(t - imu.samples[j - 1].t) / ToSeconds(imu.samples[j].t - imu.samples[j - 1].t);
  const ImuBias& a = imu.biases[j - 1];
  const ImuBias& b = imu.biases[j];
  return {(1 - u) * a.b_g + u * b.b_g, (1 - u) * a.b_a + u * b.b_a};
}

}  // namespace

SimulatedImu SimulateImu(const SplineTrajectory& trajectory,
                         Timestamp begin,
                         Timestamp end,
                         const ImuSimulatorOptions& options,
                         Rng& rng) {
  const ImuNoise& noise = options.noise;
  const double root_rate = std::sqrt(noise.rate_hz);
  const double scale = options.add_noise ? 1.0 : 0.0;
  const double sigma_gyro =
      scale * std::hypot(noise.gyro_noise * root_rate, options.gyro_vibration);
  const double sigma_accel =
      scale * std::hypot(noise.accel_noise * root_rate, options.accel_vibration);
  ImuBias bias = options.bias;
  bias.b_g += options.bias_spread_gyro * rng.Normal3();
  bias.b_a += options.bias_spread_accel * rng.Normal3();

  SimulatedImu imu;
  for (std::int64_t i = 0;; ++i) {
    const Timestamp t = begin + FromSeconds(static_cast<double>(i) / noise.rate_hz);
    if (t > end) return imu;
    ImuSample sample = trajectory.IdealImuAt(t);
    sample.gyro += bias.b_g + sigma_gyro * rng.Normal3();
    sample.accel += bias.b_a + sigma_accel * rng.Normal3();
    imu.samples.push_back(sample);
    imu.biases.push_back(bias);
    bias.b_g += scale * noise.gyro_walk / root_rate * rng.Normal3();
    bias.b_a += scale * noise.accel_walk / root_rate * rng.Normal3();
  }
}

SimulatedRun SimulateFeatures(const SplineTrajectory& trajectory,
                              const StereoRig& rig,
                              const FeatureSimulatorOptions& options,
                              std::uint64_t seed) {
  const Timestamp imu_begin = trajectory.begin() + FromSeconds(options.start_s);
  const Timestamp begin = imu_begin + FromSeconds(options.imu_lead_s);
  // One IMU sample after the last frame.
  const Timestamp last = trajectory.end() - FromSeconds(2 / options.imu.noise.rate_hz);
  const Timestamp end =
      options.duration_s > 0 ? std::min(last, begin + FromSeconds(options.duration_s)) : last;
  FACET_CHECK(end >= begin + FromSeconds(1 / options.frame_rate_hz))
      << "the trajectory is too short";

  // Independent streams: changing one part of the simulation leaves the others as they are.
  Rng rng(seed);
  Rng room_rng(rng.Next()), imu_rng(rng.Next()), track_rng(rng.Next());
  const RoomScene scene = options.corridor
                              ? RoomScene(MakeCorridor(*options.corridor, room_rng))
                              : RoomScene(PathOf(trajectory, begin, end), options.room, room_rng);
  const SimulatedImu imu = SimulateImu(trajectory,
                                       imu_begin,
                                       end + FromSeconds(2 / options.imu.noise.rate_hz),
                                       options.imu,
                                       imu_rng);

  SimulatedRun run;
  run.rig = rig;
  run.surfaces = scene.surfaces();
  run.imu = imu.samples;
  TrackSimulator tracks(rig, scene, options, track_rng);
  for (std::int64_t i = 0;; ++i) {
    const Timestamp t = begin + FromSeconds(static_cast<double>(i) / options.frame_rate_hz);
    if (t > end) return run;
    NavState truth = trajectory.At(t).state;
    truth.bias = BiasAt(imu, t);
    FrameObservations frame;
    frame.frame = FrameId{i};
    frame.t = t - rig.time_offset;
    frame.is_keyframe = i % std::max(1, options.keyframe_every) == 0;
    frame.features = tracks.Observe(truth.T_WB, frame.is_keyframe, run);
    run.frames.push_back(std::move(frame));
    run.truth.push_back(truth);
  }
}

}  // namespace facet
