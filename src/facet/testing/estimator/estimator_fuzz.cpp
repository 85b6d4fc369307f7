// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/estimator_fuzz.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/vio_estimator.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/spoilt_run.h"
#include "facet/testing/fuzz_bytes.h"

namespace facet::testing {

namespace {

constexpr int kMostCleanFrames = 8;
constexpr std::size_t kMostFrames = 60;
// The start drops frames from three times its first window on, a loss begins anew.
constexpr std::size_t kMostWindowFrames = 40;
constexpr std::size_t kMostLandmarks = 4000;

// What a byte asks for.
enum Operation {
  kCleanFrames,
  kNoFeatures,
  kOddPixel,
  kOddSigma,
  kOddLandmark,
  kShuffledLandmarks,
  kMovedFeatures,
  kOddStamp,
  kLaterForGood,
  kOddSample,
  kScaledSamples,
  kOddSampleStamp,
  kNoImu,
  kOddHole,
  kOtherKeyframe,
  kSameFrameAgain,
  kSkippedFrames,
  kPlanes,
  kNumOperations
};

// Few and cheap: a fuzzer learns from the number of runs.
const SimulatedRun& SmallRun() {
  static const SimulatedRun run = [] {
    FeatureSimulatorOptions options;
    options.max_tracks = 14;
    options.keyframe_every = 2;
    options.duration_s = 0.05 * kMostFrames;
    return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), EurocRig(), options, 1);
  }();
  return run;
}

EstimatorOptions SmallOptions() {
  EstimatorOptions options;
  options.window.max_full_keyframes = 2;
  options.window.max_pose_keyframes = 2;
  options.window.start_s = 0.4;
  options.start.min_landmarks = 6;
  return options;
}

class SpoiltEstimator {
 public:
  explicit SpoiltEstimator(std::span<const std::uint8_t> bytes)
      : bytes_(bytes), run_(SmallRun()), estimator_(run_.rig, ImuNoise(), SmallOptions()) {
    static const ImuBuffer imu = ImuOf(run_);
    imu_ = &imu;
  }

  std::string Run() {
    while (!bytes_.empty() && next_ < run_.frames.size() && problem_.empty()) {
      const auto operation = static_cast<Operation>(bytes_.Index(kNumOperations));
      if (operation == kCleanFrames) {
        for (int i = bytes_.Index(kMostCleanFrames); i >= 0; --i)
          AddFrame({});
      } else if (operation == kSkippedFrames) {
        next_ += static_cast<std::size_t>(bytes_.Index(8));
      } else if (operation == kLaterForGood) {
        later_ =
            later_ + Duration{bytes_.Flag() ? bytes_.AnyStamp() : bytes_.Byte() * 50'000'000LL};
      } else if (operation == kPlanes) {
        AssignPlanes();
      } else {
        AddFrame(operation);
      }
    }
    return problem_;
  }

 private:
  void AddFrame(Operation damage) {
    if (next_ >= run_.frames.size() || !problem_.empty()) return;
    EstimatorInput input = InputOf(run_, *imu_, next_++);
    input.observations.t = input.observations.t + later_;
    for (ImuSample& sample : input.imu.samples)
      sample.t = sample.t + later_;
    if (damage != kCleanFrames) Spoil(damage, input);
    Check(estimator_.AddFrame(input.observations, input.imu, times_));
    if (damage == kSameFrameAgain)
      Check(estimator_.AddFrame(input.observations, input.imu, times_));
  }

  void Spoil(Operation damage, EstimatorInput& input) {
    if (damage < kOddStamp) {
      SpoilFeatures(damage, input.observations.features);
    } else if (damage == kOddStamp) {
      input.observations.t = {bytes_.AnyStamp()};
    } else if (damage == kOtherKeyframe) {
      input.observations.is_keyframe = !input.observations.is_keyframe;
    } else {
      SpoilImu(damage, input.imu);
    }
  }

  void SpoilFeatures(Operation damage, std::vector<FeatureObservation>& features) {
    if (features.empty()) return;
    const auto k = static_cast<std::size_t>(bytes_.Byte()) % features.size();
    FeatureObservation& feature = features[k];
    switch (damage) {
      case kOddPixel:
        if (bytes_.Flag()) {
          feature.px_left[bytes_.Index(2)] = bytes_.Real();
        } else {
          feature.px_right = Vector2d(bytes_.Near(2000), bytes_.Real());
        }
        return;
      case kOddSigma:
        (bytes_.Flag() ? feature.sigma_left_px : feature.sigma_right_px) = bytes_.Real();
        return;
      case kOddLandmark:
        feature.landmark = bytes_.Flag() ? features.front().landmark : LandmarkId{bytes_.Integer()};
        return;
      case kShuffledLandmarks:
        for (std::size_t i = 0; i + 1 < features.size(); ++i)
          std::swap(features[i].landmark, features[(i + k) % features.size()].landmark);
        return;
      case kMovedFeatures:
        for (FeatureObservation& f : features)
          f.px_left += Vector2d(bytes_.Near(300), bytes_.Near(300));
        return;
      default:
        features.clear();
    }
  }

  void SpoilImu(Operation damage, ImuInterval& imu) {
    std::vector<ImuSample>& samples = imu.samples;
    const std::size_t n = samples.size();
    if (damage == kOddHole) {
      imu.has_hole = bytes_.Flag();
      imu.gaps = bytes_.Byte();
      imu.allowed_gap = {bytes_.AnyStamp()};
    } else if (damage == kNoImu || n == 0) {
      samples.resize(n == 0 ? 0 : bytes_.Byte() % n);
    } else if (damage == kScaledSamples) {
      const double scale = bytes_.Flag() ? bytes_.Real() : bytes_.Near(50);
      for (ImuSample& sample : samples)
        (bytes_.Flag() ? sample.gyro : sample.accel) *= scale;
    } else if (damage == kOddSampleStamp) {
      samples[bytes_.Byte() % n].t = {bytes_.AnyStamp()};
    } else if (damage == kOddSample) {
      ImuSample& sample = samples[bytes_.Byte() % n];
      Vector3d* const values[] = {
          &sample.gyro, &sample.accel, &sample.gyro_doubt, &sample.accel_doubt};
      (*values[bytes_.Index(4)])[bytes_.Index(3)] = bytes_.Real();
    }
  }

  // Planes are the program's own, so they are well formed, but they need not be true.
  void AssignPlanes() {
    PlaneAssignments assignments;
    const PlaneId plane{bytes_.Index(5)}, other{bytes_.Index(5)};
    switch (bytes_.Index(4)) {
      case 0:
        CreatePlane(plane, assignments);
        break;
      case 1:
        assignments.retired = {plane};
        break;
      case 2:
        if (plane != other) {
          assignments.relations = {{static_cast<PlaneRelationKind>(bytes_.Index(7)), plane, other}};
        }
        break;
      default:
        for (const WindowLandmark& landmark : estimator_.window().landmarks()) {
          if (bytes_.Flag()) assignments.detached.emplace_back(landmark.id, plane);
        }
        break;
    }
    estimator_.Assign(assignments);
  }

  void CreatePlane(PlaneId id, PlaneAssignments& assignments) {
    Vector3d n(bytes_.Near(1), bytes_.Near(1), bytes_.Near(1));
    n.normalize();
    const Vector3d centroid(bytes_.Near(5), bytes_.Near(5), bytes_.Near(5));
    assignments.created.push_back({id, Plane{n, n.dot(centroid)}, centroid});
    const double reach_m = std::abs(bytes_.Near(10));
    for (const WindowLandmark& landmark : estimator_.window().landmarks())
      assignments.attached.push_back({landmark.id, id, reach_m});
  }

  void Check(const EstimatorResult& result) {
    const SlidingWindow& window = estimator_.window();
    Require(window.frames.size() <= kMostWindowFrames, "the window grows");
    Require(window.landmarks().size() <= kMostLandmarks, "the landmarks grow");
    Require(result.has_state || !result.reason.empty(), "no state and no reason");
    const MapSnapshot snapshot = estimator_.Snapshot();
    if (!result.has_state) return;
    Require(IsFinite(result), "a state that is not finite");
    Require(std::abs(result.state.T_WB.q.norm() - 1) < 1e-6, "a rotation that is none");
    Require(result.covariance.diagonal().minCoeff() >= 0, "a negative variance");
    for (const LandmarkEstimate& landmark : snapshot.landmarks)
      Require(landmark.p_W.allFinite(), "a landmark that is not finite");
    for (const PlaneEstimate& plane : snapshot.planes)
      Require(plane.plane_W.n.allFinite() && std::isfinite(plane.plane_W.d),
              "a plane that is none");
  }

  void Require(bool holds, const char* what) {
    if (!holds && problem_.empty()) problem_ = what + (" at frame " + std::to_string(next_));
  }

  FuzzBytes bytes_;
  const SimulatedRun& run_;
  const ImuBuffer* imu_;
  VioEstimator estimator_;
  StageTimes times_;
  std::size_t next_ = 0;
  Duration later_;
  std::string problem_;
};

}  // namespace

std::string FuzzEstimator(std::span<const std::uint8_t> bytes) {
  return SpoiltEstimator(bytes).Run();
}

std::vector<std::vector<std::uint8_t>> EstimatorFuzzSeeds() {
  const std::vector<std::uint8_t> clean = {kCleanFrames, 7, kCleanFrames, 7};
  const std::vector<std::uint8_t> plane = {kPlanes, 1, 0, 0, 128, 128, 255, 128, 128, 128, 255};
  std::vector<std::vector<std::uint8_t>> seeds = {clean};
  for (std::uint8_t operation = kNoFeatures; operation < kNumOperations; ++operation) {
    std::vector<std::uint8_t>& seed = seeds.emplace_back(clean);
    if (operation % 3 == 0) seed.insert(seed.end(), plane.begin(), plane.end());
    for (const std::uint8_t argument : std::vector<std::uint8_t>{3, 1, 7})
      seed.insert(seed.end(), {operation, argument, argument, argument, kCleanFrames, 2});
    seed.insert(seed.end(), clean.begin(), clean.end());
  }
  return seeds;
}

}  // namespace facet::testing
