// SPDX-License-Identifier: BSD-2-Clause
// The calibration over a run: what is known of it at the start, after a loss and at the end, and
// how it is forgotten a little as time goes by.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "facet/calibration/calibration_deviation.h"
#include "facet/calibration/error_evidence.h"
#include "facet/estimator/calibration_care.h"
#include "facet/estimator/estimator_options.h"
#include "facet/estimator/estimator_result.h"
#include "facet/estimator/solver/window_solver.h"

namespace facet {

/// Birge's ratio of a calibration that has changed by `delta`, where `possible` was what was
/// believed of it, and `left` is what is not known now: the squares of the change in units of what
/// was possible over what they are expected to be, the number of parameters that were learnt, and a
/// few that count as if they had been as expected. Those that are held have nearly no variance,
/// before and after, so that they are not among the learnt.
double CalibrationSurprise(const CalibrationVector& delta,
                           const CalibrationMatrix& possible,
                           const CalibrationMatrix& left);

/// What is left not known of a calibration of which `possible` was believed before, if `left` is
/// what the measurements leave with the noise that was assumed of them, and their variances are
/// `factor` times that.
CalibrationMatrix LeftWithNoise(double factor,
                                const CalibrationMatrix& possible,
                                const CalibrationMatrix& left);

/// Does nothing if all of the calibration is held. Not thread-safe.
class SelfCalibration {
 public:
  SelfCalibration(const StereoRig& rig, const CalibrationOptions& options);

  /// Makes the calibration a variable of an empty window: as it was given, or, after a loss, as it
  /// was last kept.
  void Begin(SlidingWindow& window);

  /// After a keyframe's solve.
  void TakeClock(const SlidingWindow& window, const WindowSolver& solver);
  /// And if its state is good; looks again after a second.
  void Keep(const SlidingWindow& window, const WindowSolver& solver);

  /// After marginalisation: from time to time it takes a random step. A part of it that has turned
  /// out to be wrong by more than was believed possible takes a large one, up to three times; until
  /// then parts that turn out to be better than was believed are believed more. Lenses and a pair
  /// of which what was measured says that they are wrong by far more are given room before that.
  void Walk(SlidingWindow& window);

  /// The distance between the cameras may be wrong by this share of it. Counts with the next Walk,
  /// if lenses and stereo pair are estimated.
  void DoubtBaseline(double share) { doubted_share_ = share; }

  /// After a keyframe's solve: whether IMU and images have contradicted each other within the last
  /// second. Until that has lasted for some seconds a sensor was wrong and not the calibration: no
  /// part of it is kept, called wrong or freed meanwhile.
  void Doubt(Timestamp now, bool is_contradicted);

  /// What is wrong by more than a careful calibration leaves, as last kept, in parts that were
  /// given room or have taken a large step, and have settled; and in the mount, as it would be if
  /// it had room.
  const std::vector<CalibrationDeviation>& Gross() const { return gross_deviations_; }

  /// What is off in this part is as it was measured, not held back by what was believed.
  bool HasRoom(CalibrationPart part) const;

  /// Of the calibration as last kept, against the given one: about 1 for a careful one, no more
  /// for an exact one, 0 if held.
  double Surprise() const { return surprise_; }

  /// When a part was given room or took a large step last.
  const std::optional<Timestamp>& freed_at() const { return freed_at_; }

  /// Moves a state and its covariance from the nominal stamp, for which they are estimated, to when
  /// the image was taken.
  void MoveToImage(const SlidingWindow& window,
                   const ImageMotion& motion,
                   EstimatorResult& result) const;

  /// How much later images are taken than their stamps and the nominal calibration say [s].
  static double TimeOffset(const SlidingWindow& window) {
    return window.calibration ? window.calibration->delta()(kTimeOffset) : 0.0;
  }

  /// As it was last kept, with its covariance if the measurements' variances were `noise_factor`
  /// times what was assumed of them; empty before, and if all of it is held.
  std::optional<StereoRig> Refined(double noise_factor) const;
  /// The same without the covariance, until the next call of Keep; null: empty.
  const StereoRig* KeptRig() const { return kept_ ? &kept_->rig : nullptr; }

 private:
  // What may be wrong by as much as in rigs that nobody calibrated with care.
  struct Room {
    bool lenses = false;         // and everything between the cameras but their distance
    bool focal_lengths = false;  // both, by the same share
  };

  struct Kept {
    Timestamp t;
    CalibrationVector delta;
    CalibrationMatrix possible, covariance;  // before and after what was learnt
    Room room;
    std::optional<CalibrationCare> care;  // as it was with that covariance
    StereoRig rig;
  };

  /// False if the prior does not know the calibration.
  bool TakeStep(const CalibrationMatrix& covariance, SlidingWindow& window);
  /// What is off beyond what has room.
  CalibrationVector BeyondRoom() const;
  // Once each time something new was kept.
  void JudgeLenses(SlidingWindow& window);
  void JudgeFocalLengths(SlidingWindow& window);
  void JudgeMount();
  bool IsMountJudged() const;
  void ForgetMount();
  void AddMount();
  void JudgeCare(SlidingWindow& window);
  void GiveUpCare(SlidingWindow& window);
  void GiveRoom(std::span<const CalibrationVector> errors, SlidingWindow& window);
  /// Of the large step that is due now; empty if none is.
  std::optional<CalibrationMatrix> LargeStep();
  int& NumLargeSteps(CalibrationPart part) {
    return num_large_steps_[static_cast<std::size_t>(part)];
  }

  StereoRig rig_;
  CalibrationOptions options_;
  std::optional<CalibrationMatrix> start_covariance_;
  CalibrationMatrix possible_ =
      CalibrationMatrix::Zero();         // that, as it is believed now, with all steps
  std::optional<CalibrationCare> care_;  // until a part was given much room
  double surprise_ = 0;
  ClockCovariance clock_;
  std::optional<Kept> kept_;
  std::optional<Timestamp> judged_;  // what was kept then
  std::optional<Timestamp> last_step_;
  double doubted_share_ = 0;
  std::array<int, kNumCalibrationParts> num_large_steps_{};
  // In turn, at parts that are rough.
  int num_looks_at_lenses_ = 0, num_looks_at_focal_lengths_ = 0, num_looks_at_mount_ = 0;
  Room room_;
  std::optional<Timestamp> first_kept_;
  std::optional<CalibrationVector> found_lenses_;  // once they have had room for long
  std::optional<Timestamp> freed_at_;  // when a part took the last step, or was given room
  // Of parts that have had room for a while, and of the mount.
  std::vector<CalibrationDeviation> gross_deviations_;
  std::optional<FreedEstimate> rough_mount_;      // which is called wrong without room
  std::vector<CalibrationDeviation> unexpected_;  // for which a part is to take a large step
  std::optional<Timestamp> contradicted_since_;
  bool is_doubted_ = false;
};

}  // namespace facet
