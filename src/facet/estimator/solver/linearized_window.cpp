// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/linearized_window.h"

#include "facet/estimator/factors/window_factors.h"
#include "facet/estimator/solver/landmark_elimination.h"

namespace facet {

namespace {

void ClearCouplings(const SlidingWindow& window, LinearizedWindow& linear) {
  const std::size_t num_frames = window.frames.size();
  linear.coupled_with_motion.resize(num_frames);
  for (std::size_t i = 0; i < num_frames; ++i) {
    linear.coupled_with_motion[i].Clear(num_frames, window.planes.size());
    // A motion goes together with its own pose, whatever the factors say.
    if (window.frames[i].has_motion)
      linear.coupled_with_motion[i].Insert(Variable::Pose(static_cast<int>(i)));
  }
}

void AddCouplings(const auto& factor, LinearizedWindow& linear) {
  factor.ForEachVariable([&](Variable variable) {
    if (variable.kind != Variable::Kind::kMotion) return;
    VariableSet& coupled = linear.coupled_with_motion[variable.index];
    factor.ForEachVariable([&](Variable other) { coupled.Insert(other); });
  });
}

// What the measurements add to the planes' blocks is their information.
void AddMeasurements(const SlidingWindow& window,
                     const FactorNoise& noise,
                     LinearizedWindow& linear) {
  NormalEquations& equations = linear.equations;
  const auto on_diagonal = [&](std::size_t plane) {
    const int column = equations.layout.plane_column[plane];
    return equations.H.block<3, 3>(column, column);
  };
  linear.measured.resize(window.planes.size());
  for (std::size_t k = 0; k < linear.measured.size(); ++k)
    linear.measured[k] = -on_diagonal(k);
  VisitPlaneMeasurements(
      window, noise, [&](const Factor auto& factor) { linear.cost += factor.AddTo(equations); });
  for (std::size_t k = 0; k < linear.measured.size(); ++k)
    linear.measured[k] += on_diagonal(k);
}

std::size_t NumViews(const SlidingWindow& window) {
  std::size_t num = 0;
  for (const WindowLandmark& landmark : window.landmarks())
    num += IsConstraining(landmark) ? landmark.observations.size() : 0;
  return num;
}

void AddLandmarks(const SlidingWindow& window,
                  const FrameGeometry& geometry,
                  const FactorNoise& noise,
                  LinearizedWindow& linear) {
  const StateLayout& layout = linear.layout();
  const bool is_apart = layout.calibration_column >= 0;
  MatrixXd& H = is_apart ? linear.vision_H : linear.equations.H;
  VectorXd& b = is_apart ? linear.vision_b : linear.equations.b;
  if (is_apart) {
    H.setZero(layout.dense_dim, layout.dense_dim);
    b.setZero(layout.dense_dim);
    linear.lens_sums.Clear(window.frames.size());
    linear.mounts = MountJacobiansOf(window, geometry);
  }
  LensSums* const lens = is_apart ? &linear.lens_sums : nullptr;
  const auto& landmarks = window.landmarks();
  linear.num_landmarks = 0;
  if (linear.landmarks.size() < landmarks.size()) linear.landmarks.resize(landmarks.size());
  linear.views.resize(NumViews(window));
  std::span<LandmarkBlock::View> views = linear.views;
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    if (!IsConstraining(landmarks[l])) continue;
    LandmarkBlock& block = linear.landmarks[linear.num_landmarks++];
    block.index = static_cast<int>(l);
    block.views = views.first(landmarks[l].observations.size());
    views = views.subspan(block.views.size());
    block.pose_squares.swap(linear.pose_squares);
    LinearizeLandmark(geometry, window.planes, landmarks[l], noise, block, lens);
    linear.cost += block.cost;
    AddDiagonal(block, layout, H, b);
    block.pose_squares.swap(linear.pose_squares);
  }
  if (is_apart) AddLensSums(linear.lens_sums, layout, H, b);
}

}  // namespace

void Linearize(const SlidingWindow& window,
               const FrameGeometry& geometry,
               const FactorNoise& noise,
               CalibrationStep calibration_step,
               LinearizedWindow& linear) {
  linear.equations.Clear(window, calibration_step);
  ClearCouplings(window, linear);
  linear.loss_width = noise.reprojection_width;
  linear.cost = 0;
  VisitAllButPlaneMeasurements(window, noise, [&](const Factor auto& factor) {
    linear.cost += factor.AddTo(linear.equations);
    AddCouplings(factor, linear);
  });
  AddMeasurements(window, noise, linear);
  AddLandmarks(window, geometry, noise, linear);
}

double WindowCost(const SlidingWindow& window,
                  const FrameGeometry& geometry,
                  const FactorNoise& noise) {
  double cost = 0;
  VisitFactors(window, noise, [&](const Factor auto& factor) { cost += factor.Cost(); });
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (IsConstraining(landmark)) cost += LandmarkCost(geometry, window.planes, landmark, noise);
  }
  return cost;
}

}  // namespace facet
