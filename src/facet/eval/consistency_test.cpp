// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

NavState TruthState(double t) {
  NavState s;
  s.t = Timestamp{1'000'000'000 + FromSeconds(t).ns};
  s.T_WB = SE3(ExpSO3({0.1 * std::sin(t), 0.2, t}), {2 * std::cos(t), 2 * std::sin(t), 0.1 * t});
  s.v_WB = {-2 * std::sin(t), 2 * std::cos(t), 0.1};
  s.bias = {{0.01, 0.02, 0.03}, {0.1, 0.2, 0.3}};
  return s;
}

std::vector<NavState> Truth() {
  std::vector<NavState> truth;
  for (int i = 0; i < 12000; ++i)
    truth.push_back(TruthState(0.005 * i));
  return truth;
}

// Estimates in another world (heading and place), with errors of `scale` times the stated sigmas.
std::vector<EstimatedState> NoisyEstimate(double scale) {
  Rng rng(3);
  const SE3 T_WG(ExpSO3({0, 0, 0.7}), {4, 5, 6});
  std::vector<EstimatedState> estimate;
  for (int i = 0; i < 1190; ++i) {
    const NavState truth = TruthState(0.05 * i + 0.01);
    EstimatedState e;
    e.state = truth;
    e.state.T_WB = T_WG * truth.T_WB;
    e.state.v_WB = T_WG.q * truth.v_WB;
    e.sigma_p = {0.01, 0.02, 0.03};
    e.sigma_theta = {0.001, 0.002, 0.003};
    e.sigma_v = {0.05, 0.06, 0.07};
    if (i > 0) {
      const auto noise = [&](const Vector3d& sigma) -> Vector3d {
        return scale * sigma.cwiseProduct(rng.Normal3());
      };
      e.state.T_WB = e.state.T_WB.Retract(noise(e.sigma_theta), noise(e.sigma_p));
      e.state.v_WB += noise(e.sigma_v);
      e.state.bias.b_g += noise({0.003, 0.003, 0.003});
    }
    estimate.push_back(e);
  }
  return estimate;
}

TEST(ConsistencyTest, OneForTrueSigmasAndFourForHalfOfThem) {
  for (double scale : {1.0, 2.0}) {
    const ConsistencyError error = EvaluateConsistency(NoisyEstimate(scale), Truth());
    for (const auto& part : {error.position, error.orientation, error.velocity}) {
      ASSERT_TRUE(part);
      EXPECT_NEAR(part->nees, scale * scale, 0.08 * scale * scale);
      EXPECT_NEAR(part->within_two_sigma, scale == 1 ? 0.954 : 0.683, 0.02);
      EXPECT_EQ(part->num_states, 1186u);
    }
  }
}

TEST(ConsistencyTest, BiasesWithoutSigmaHaveAnErrorOnly) {
  const ConsistencyError error = EvaluateConsistency(NoisyEstimate(1), Truth());
  ASSERT_TRUE(error.gyro_bias);
  EXPECT_EQ(error.gyro_bias->num_states, 0u);
  EXPECT_NEAR(error.gyro_bias->rmse, 0.003 * std::sqrt(3), 0.0004);
  EXPECT_NEAR(error.accel_bias->rmse, 0, 1e-12);
}

TEST(ConsistencyTest, PartsWithoutTruthAreAbsent) {
  std::vector<NavState> truth = Truth();
  for (NavState& s : truth)
    s.bias = {Unknown3(), Unknown3()};
  const ConsistencyError error = EvaluateConsistency(NoisyEstimate(1), truth);
  EXPECT_TRUE(error.position);
  EXPECT_FALSE(error.gyro_bias);
  EXPECT_FALSE(EvaluateConsistency({}, truth).position);
}

TEST(StatesFileTest, FindsColumnsByName) {
  const TempFolder folder;
  WriteText(folder / "states.csv",
            "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz,sigma_px,sigma_py,"
            "sigma_pz,sigma_rx,sigma_ry,sigma_rz,sigma_vx,sigma_vy,sigma_vz,status,reason\n"
            "5,,,,,,,,,,,,,,,,,,,,,,,,,,initialising,\n"
            "7,1,2,3,1,0,0,0,4,5,6,.1,.2,.3,1,2,3,.01,.02,.03,.001,.002,.003,.4,.5,.6,ok,\n");
  const auto states = ReadStates(folder / "states.csv");
  ASSERT_EQ(states.size(), 1u);
  EXPECT_EQ(states[0].state.t.ns, 7);
  EXPECT_EQ(states[0].state.v_WB, Vector3d(4, 5, 6));
  EXPECT_EQ(states[0].sigma_theta, Vector3d(.001, .002, .003));
  EXPECT_FALSE(states[0].sigma_b_g.allFinite());
}

TEST(StatesFileTest, NamesFileAndLine) {
  const TempFolder folder;
  WriteText(folder / "states.csv", "time,x\n1,2\n");
  try {
    ReadStates(folder / "states.csv");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("states.csv:1: there is no column 'timestamp_ns'"));
  }
}

TEST(StatesFileTest, ARowMayEndBeforeTheLastNameOfAHeaderWithNamesTwice) {
  const TempFolder folder;
  WriteText(folder / "states.csv",
            "timestamp_ns,px,px,px,px,px,px,py,pz,qw,qx,qy,qz,vx,sigma_px,sigma_rx\n"
            "7,1,1,1,1,1,1,2,3,1,0\n");
  const auto read = [&] { ReadStates(folder / "states.csv"); };
  EXPECT_THROW(read(), InputError);  // of the quaternion, which ends early
  WriteText(folder / "states.csv",
            "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,a,a,a,a,sigma_px,sigma_rx\n"
            "7,1,2,3,1,0,0,0,4,5,5,5\n");
  EXPECT_EQ(ReadStates(folder / "states.csv").size(), 1u);
}

TEST(StatesFileTest, ASigmaIsANumberFromZeroOnOrUnknown) {
  const TempFolder folder;
  const auto read = [&](const std::string& sigma) -> std::string {
    WriteText(folder / "states.csv",
              "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,sigma_px,sigma_py,sigma_pz,sigma_rx,"
              "sigma_ry,sigma_rz\n7,1,2,3,1,0,0,0,4,5,6,.01,.02,.03,.1," +
                  sigma + ",.3\n");
    try {
      const auto states = ReadStates(folder / "states.csv");
      return states.size() == 1 && states[0].sigma_theta.allFinite() ? "known" : "unknown";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(read("0.2"), "known");
  EXPECT_EQ(read("0"), "known");
  EXPECT_EQ(read(""), "unknown");
  EXPECT_EQ(read("nan"), "unknown");
  for (const char* bad : {"-0.2", "inf", "-inf", "1e999", "large"})
    EXPECT_THAT(read(bad), HasSubstr("states.csv:2: sigma_ry is '" + std::string(bad) + "'"));
}

}  // namespace
}  // namespace facet
