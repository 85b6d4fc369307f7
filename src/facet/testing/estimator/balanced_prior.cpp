// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/balanced_prior.h"

namespace facet::testing {

SolverOptions ExactOptions() {
  SolverOptions options;
  options.loss_width = 0;  // the width stays what the noise says
  options.min_cost_decrease = 0;
  return options;
}

TestWindow MakeOptimumWindow(std::uint64_t seed, int num_pose_frames) {
  Rng rng(seed);
  TestWindowOptions options;
  options.num_frames = 5 + rng.Index(3);
  options.num_pose_frames = num_pose_frames;
  options.num_landmarks = 30;
  options.right_share = rng.Uniform(0.2, 0.8);
  options.outlier_share = 0.02;
  TestWindow test = MakeTestWindow(options, rng);
  // A landmark that is seen once must not matter to anyone.
  test.window.landmarks().back().observations.resize(1);
  return test;
}

void AddBalancedPrior(TestWindow& test, Rng& rng, const FactorNoise& noise) {
  MarginalPrior& prior = test.window.prior;
  int dim = 0;
  for (std::size_t k = 0; k < test.window.planes.size(); k += 2) {
    test.window.planes[k].Freeze();
    prior.blocks.push_back(MarginalPrior::Block::OfPlane(test.window.planes[k].id, dim));
    dim += 3;
  }
  for (int i = 0; i < 2; ++i) {
    WindowFrame& frame = test.window.frames[i];
    frame.FreezePose();
    prior.blocks.push_back(MarginalPrior::Block::OfPose(frame.id, dim));
    dim += 6;
    if (!frame.has_motion) continue;
    frame.FreezeMotion();
    prior.blocks.push_back(MarginalPrior::Block::OfMotion(frame.id, dim));
    dim += 9;
  }
  MatrixXd A(dim, dim);
  for (int r = 0; r < dim; ++r) {
    for (int c = 0; c < dim; ++c)
      A(r, c) = rng.Normal();
  }
  prior.H = 1e5 * (A * A.transpose() + MatrixXd::Identity(dim, dim));
  prior.b = VectorXd::Zero(dim);
  prior.b = -SolveWithCeres(test.window, test.rig, {noise, true}).prior_gradient;
}

}  // namespace facet::testing
