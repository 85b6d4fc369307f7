// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/frame_records.h"

#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

RunRecord TwoFrames() {
  RunRecord run;
  run.frames.resize(2);
  run.frames[0].t = {1000};
  run.frames[0].status = "initialising";
  run.frames[0].reason = "no, not \"yet\"";
  FrameRecord& f = run.frames[1];
  f.t = {1403715288300000001};
  f.is_keyframe = f.has_pose = true;
  f.segment = 2;
  f.state.T_WB = {Quaterniond(0.5, 0.5, -0.5, 0.5), Vector3d(1, 2, 3)};
  f.state.v_WB = {4, 5, 6};
  f.state.bias.b_g = {0.1, 0.2, 0.3};
  f.sigma_b_a = {7, 8, 9};
  f.status = "ok";
  f.times[Stage::kMesh] = 1.25;
  f.latency_ms = 3;
  f.num_planes = 4;
  return run;
}

TEST(FrameRecords, WhatARunWroteIsReadAgain) {
  const TempFolder folder;
  const RunRecord run = TwoFrames();
  WriteResult(folder.path(), run);
  const std::vector<FrameRecord> frames = ReadFrameRecords(folder.path());
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_FALSE(frames[0].has_pose);
  EXPECT_EQ(frames[0].status, "initialising");
  EXPECT_EQ(frames[0].reason, "no, not yet");
  const FrameRecord &f = frames[1], &wrote = run.frames[1];
  EXPECT_EQ(f.t, wrote.t);
  EXPECT_TRUE(f.is_keyframe);
  EXPECT_EQ(f.segment, 2);
  EXPECT_TRUE(f.state.T_WB.p.isApprox(wrote.state.T_WB.p));
  EXPECT_TRUE(f.state.T_WB.q.isApprox(wrote.state.T_WB.q));
  EXPECT_EQ(f.state.bias.b_g, wrote.state.bias.b_g);
  EXPECT_EQ(f.sigma_b_a, wrote.sigma_b_a);
  EXPECT_EQ(f.times[Stage::kMesh], 1.25);
  EXPECT_EQ(f.latency_ms, 3);
  EXPECT_EQ(f.num_planes, 4);
}

TEST(FrameRecords, StatesThatWereCutOffAreRefused) {
  const TempFolder folder;
  WriteResult(folder.path(), TwoFrames());
  const auto states = folder / "states.csv";
  Truncate(states, ReadText(states).size() - 40);
  EXPECT_THROW(ReadFrameRecords(folder.path()), InputError);
  Truncate(states, 0);
  EXPECT_THROW(ReadFrameRecords(folder.path()), InputError);
}

TEST(FrameRecords, WithoutStatesTheTrajectoryIsAllThereIs) {
  const TempFolder folder;
  EXPECT_THROW(ReadFrameRecords(folder.path()), InputError);
  WriteTum(folder.path() / "trajectory.tum", TwoFrames().CausalTrajectory());
  const std::vector<FrameRecord> frames = ReadFrameRecords(folder.path());
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].t.ns, 1403715288300000001);
  EXPECT_TRUE(frames[0].sigma_p.hasNaN());
}

}  // namespace
}  // namespace facet
