// SPDX-License-Identifier: BSD-2-Clause
// Whether right images are where the calibration says: cameras swapped, the right one turned,
// lenses that do not fit, right images of another moment.
#include <cmath>

#include "facet/check/detectors.h"
#include "facet/geometry/angles.h"
#include "facet/plausibility/wide_stereo_match.h"

namespace facet {
namespace {

// Matches for the calibration: as far from the epipolar lines as a small turn takes them. For the
// moment of the right image, they may be farther.
constexpr double kGate_px = 5, kWideGate_px = 15;
constexpr std::size_t kMostRays = 20000, kMostTurns = 1000;
constexpr std::size_t kMinRays = 150;
// What careful calibrations leave is 0.2 px, at most 0.5 px.
constexpr double kMisfit_px = 0.65;

// The turn of a pair counts with this many matches at least.
constexpr int kMinOfPair = 40;
constexpr std::size_t kMinPairs = 12;
constexpr double kLate_s = 0.008, kLateSigmas = 3;

class StereoGeometry : public Detector {
 public:
  explicit StereoGeometry(const StereoRig& rig) : rig_(rig) {}

  void OnImu(const ImuSample& sample) override { gyro_ = sample.gyro; }

  void OnImages(const ImagePair& pair) override {
    if (pair.right.empty() || rays_.size() > kMostRays || turns_.size() > kMostTurns) return;
    const std::vector<StereoRays> rays = MatchWidely(rig_, pair.left, pair.right, kGate_px);
    rays_.insert(rays_.end(), rays.begin(), rays.end());
    if (rays.size() < kFewStereoMatches)
      num_exchanged_ += MatchWidely(rig_, pair.right, pair.left, kGate_px).size();
    const StereoTurn turn =
        EstimateStereoTurn(rig_, MatchWidely(rig_, pair.left, pair.right, kWideGate_px));
    if (turn.num_matches >= kMinOfPair)
      turns_.push_back({turn.omega, rig_.T_BC[1].q.conjugate() * gyro_});
  }

  void Finish(CheckReport& report) override {
    if (AreSwapped(rays_.size(), num_exchanged_)) {
      report.Add({"cameras_swapped",
                  Sureness::kCertain,
                  Text("the cameras are swapped: %zu corners match when left and right images are "
                       "exchanged, otherwise %zu",
                       num_exchanged_,
                       rays_.size()),
                  "exchange cam0 and cam1, or the topics, or the calibrations"});
      return;
    }
    if (FinishMoment(report)) return;
    FinishTurn(report);
  }

 private:
  struct PairTurn {
    Vector3d omega, gyro_C1;
  };

  /// A right image that is late by tau is turned by tau times the rate. About y it cannot be seen.
  bool FinishMoment(CheckReport& report) const {
    if (turns_.size() < kMinPairs) {
      report.unchecked.push_back({"right_late", "too few pairs with matches"});
      return false;
    }
    Vector3d mean_omega = Vector3d::Zero(), mean_gyro = Vector3d::Zero();
    for (const PairTurn& turn : turns_) {
      mean_omega += turn.omega / static_cast<double>(turns_.size());
      mean_gyro += turn.gyro_C1 / static_cast<double>(turns_.size());
    }
    double products = 0, squares = 0, left = 0;
    for (const PairTurn& turn : turns_) {
      for (const int k : {0, 2}) {
        products += (turn.omega - mean_omega)[k] * (turn.gyro_C1 - mean_gyro)[k];
        squares += std::pow((turn.gyro_C1 - mean_gyro)[k], 2);
      }
    }
    const double tau_s = products / std::max(squares, 1e-12);
    for (const PairTurn& turn : turns_) {
      for (const int k : {0, 2}) {
        const double e = (turn.omega - mean_omega)[k] - tau_s * (turn.gyro_C1 - mean_gyro)[k];
        left += e * e;
      }
    }
    const double num = 2.0 * static_cast<double>(turns_.size()) - 3;
    const double sigma_s = std::sqrt(left / num / std::max(squares, 1e-12));
    report.measured.push_back(
        Text("right images are later than left ones by %.1f ms (1-sigma %.1f)",
             1e3 * tau_s,
             1e3 * sigma_s));
    if (std::abs(tau_s) < kLate_s || std::abs(tau_s) < kLateSigmas * sigma_s) return false;
    report.Add({"right_late",
                Sureness::kLikely,
                Text("right images are %.0f ms %s than the left ones that they are paired with: "
                     "the faster the camera turns, the farther matches are beside their epipolar "
                     "lines",
                     1e3 * std::abs(tau_s),
                     tau_s > 0 ? "later" : "earlier"),
                "trigger both cameras together; look for a queue that pairs images of different "
                "moments"});
    return true;
  }

  void FinishTurn(CheckReport& report) const {
    const StereoTurn turn = EstimateStereoTurn(rig_, rays_);
    if (rays_.size() < kMinRays) {
      for (const char* name : {"right_turned", "stereo_misfit"})
        report.unchecked.push_back({name, "too few matches of left and right images"});
      return;
    }
    const Vector3d degrees = turn.omega / kDegree;
    report.measured.push_back(
        Text("matches of left and right are %.2f px beside their epipolar lines (median of %d), "
             "%.2f px with the right camera turned by %.2f deg",
             turn.before_px,
             turn.num_matches,
             turn.after_px,
             degrees.norm()));
    if (turn.after_px > kMisfit_px) {
      report.Add({"stereo_misfit",
                  Sureness::kCertain,
                  Text("matches of left and right images are %.1f px beside their epipolar lines "
                       "(median of %d), and %.1f px whichever way the right camera is turned",
                       turn.before_px,
                       turn.num_matches,
                       turn.after_px),
                  "calibrate again; is it the calibration of these cameras, with this resolution "
                  "and these lenses?"});
    } else if (turn.IsClear()) {
      report.Add({"right_turned",
                  Sureness::kCertain,
                  Text("the right camera is turned by %.2f, %.2f, %.2f deg about its x, y, z axes "
                       "against its calibration: matches are %.1f px beside their epipolar lines "
                       "(median of %d), %.1f px with this correction",
                       degrees.x(),
                       degrees.y(),
                       degrees.z(),
                       turn.before_px,
                       turn.num_matches,
                       turn.after_px),
                  "calibrate again; facet run begins with this correction"});
    }
  }

  StereoRig rig_;
  Vector3d gyro_ = Vector3d::Zero();  // newest
  std::vector<StereoRays> rays_;
  std::size_t num_exchanged_ = 0;
  std::vector<PairTurn> turns_;
};

}  // namespace

std::unique_ptr<Detector> MakeStereoGeometry(const StereoRig& rig) {
  return std::make_unique<StereoGeometry>(rig);
}

}  // namespace facet
