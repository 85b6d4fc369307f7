// SPDX-License-Identifier: BSD-2-Clause
// The data of the fixed-lag smoother: frames, planes, landmarks, the links between them and the
// priors. Plain data with the few operations that keep it consistent; the mathematics lives in
// factors/ and solver/.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "facet/estimator/window/window_frame.h"
#include "facet/estimator/window/window_landmark.h"
#include "facet/estimator/window/window_measurement.h"
#include "facet/estimator/window/window_priors.h"

namespace facet {

/// What is removed takes along every measurement that has lost one of its variables.
class SlidingWindow {
 public:
  SlidingWindow() = default;
  /// T_BC0: left camera of the rig on the body; the bearings of landmarks are taken there.
  explicit SlidingWindow(const SE3& left_camera) : T_BC0(left_camera) {}

  std::vector<WindowFrame> frames;  ///< oldest first
  std::vector<WindowPlane> planes;
  std::vector<WindowRelation> relations;
  std::vector<WindowMeasurement> measurements;  ///< of these frames and planes
  MarginalPrior prior;
  std::optional<StartPrior> start_prior;
  SE3 T_BC0;                                     ///< nominal
  std::optional<WindowCalibration> calibration;  ///< empty: the nominal one is exact

  const std::vector<WindowLandmark>& landmarks() const { return landmarks_; }
  std::vector<WindowLandmark>& landmarks() { return landmarks_; }

  /// T_WB when the frame's image is taken.
  SE3 BodyAt(int frame) const;
  /// T_WC0 when the frame's image is taken.
  SE3 LeftCameraAt(int frame) const;

  /// By what share the gyroscope reads too much at present; zero without a calibration.
  Vector3d GyroScale() const { return calibration ? calibration->gyro_scale() : Vector3d::Zero(); }

  int newest_frame() const { return static_cast<int>(frames.size()) - 1; }

  /// Null if the landmark is not in the window.
  WindowLandmark* Find(LandmarkId id);
  /// Index of the frame or plane, or -1.
  int IndexOf(FrameId id) const;
  int IndexOf(PlaneId id) const;
  Variable VariableOf(const MarginalPrior::Block& block) const;

  WindowLandmark& AddLandmark(LandmarkId id, int host);

  /// Removes the landmarks for which `flags[i]` is set.
  void RemoveLandmarks(const std::vector<char>& flags);

  /// Removes a frame with its IMU links, its measurements and every observation in it; landmarks
  /// hosted there move to their next observation, those without any observation go; relations tied
  /// to it are tied to another frame. The prior must not contain the frame.
  void RemoveFrame(int index);

  /// Removes velocity and biases of a frame, with its IMU links; its pose stays. The prior must not
  /// contain them.
  void RemoveMotion(int index);

  /// Removes a plane, the links to it, its relations and its measurements. The prior must not
  /// contain it.
  void RemovePlane(int index);

  /// False if the relation exists, or a plane of it does not, or there is no frame to tie it to.
  bool AddRelation(const PlaneRelation& relation);

  /// Ties the relation to the newest frame but the one with index `leaving`, at a point between its
  /// planes.
  void AttachRelation(WindowRelation& relation, int leaving = -1) const;

  /// Where the landmark is in the world; its inverse distance must not be 0.
  Vector3d PositionOf(const WindowLandmark& landmark) const;

  /// Moves a landmark to another frame, keeping its place in the world (docs/math.md, equation
  /// (3.8)).
  void Rehost(WindowLandmark& landmark, int new_host);

  /// How many landmarks lie on each plane, and in all: one on two planes counts twice.
  std::vector<int> CountPlaneLandmarks() const;
  int NumPlaneLandmarks() const;

 private:
  using IndexEntry = std::pair<LandmarkId, int>;

  void CutImuLinks(int frame);
  void RebuildIndex();
  /// Where the landmark is in the index, or would be.
  std::vector<IndexEntry>::iterator PlaceInIndex(LandmarkId id);

  std::vector<WindowLandmark> landmarks_;
  std::vector<IndexEntry> index_;  // into landmarks_, by id
};

}  // namespace facet
