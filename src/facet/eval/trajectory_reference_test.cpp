// SPDX-License-Identifier: BSD-2-Clause
// The evaluation against others: published values, and scripts/naive_ate.py, which shares no code
// with it.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "facet/base/random.h"
#include "facet/eval/evaluation_json.h"
#include "facet/eval/run_evaluation.h"
#include "facet/geometry/so3.h"
#include "facet/testing/data_dir.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kPython = "/usr/bin/python3";

bool HasNumpy() {
  return std::system((std::string(kPython) + " -c 'import numpy' 2>/dev/null").c_str()) == 0;
}

std::string OutputOf(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  char buffer[4096];
  while (pipe != nullptr && std::fgets(buffer, sizeof(buffer), pipe.get()) != nullptr) {
    output += buffer;
  }
  return output;
}

// What the independent implementation says about the same lengths.
ordered_json NaiveEvaluation(const fs::path& estimate,
                             const fs::path& truth,
                             const ordered_json& rpe,
                             const std::string& more) {
  std::string command = std::string(kPython) + " " + testing::SourceFolder().string() +
                        "/scripts/naive_ate.py '" + estimate.string() + "' '" + truth.string() +
                        "' " + more + " --lengths";
  for (const auto& entry : rpe) {
    command += ' ';
    command += entry["length_m"].dump();
  }
  return ordered_json::parse(OutputOf(command), nullptr, false);
}

void ExpectEqualNumbers(const ordered_json& ours, const ordered_json& naive) {
  for (const auto& [key, value] : naive.items()) {
    SCOPED_TRACE(key);
    ASSERT_TRUE(ours.contains(key));
    EXPECT_NEAR(ours[key].get<double>(), value.get<double>(), 1e-9);
  }
}

void ExpectAgreesWithNaive(const fs::path& estimate,
                           const fs::path& truth,
                           AlignmentKind alignment = AlignmentKind::kSE3,
                           bool align_time = false) {
  EvaluationOptions options;
  options.trajectory.alignment = alignment;
  options.align_time = align_time;
  const RunEvaluation evaluation = EvaluateRun(estimate, LoadGroundTruth(truth), options);
  const ordered_json ours = ToJson(evaluation);
  const std::int64_t offset_ns = evaluation.time_offset.value_or(Duration{}).ns;
  // Relative errors do not depend on the alignment; once is enough for the slow implementation.
  const bool with_rpe = alignment == AlignmentKind::kSE3 && !align_time;
  const ordered_json naive = NaiveEvaluation(estimate,
                                             truth,
                                             with_rpe ? ours["rpe"] : ordered_json::array(),
                                             std::string("--alignment ") + ToString(alignment) +
                                                 " --time-offset-ns=" + std::to_string(offset_ns));
  ASSERT_TRUE(naive.is_object()) << "naive_ate.py failed";
  EXPECT_EQ(ours["poses_with_truth"], naive["poses"]);
  ExpectEqualNumbers(ours["ate"], naive["ate"]);
  if (!with_rpe) return;
  ASSERT_EQ(ours["rpe"].size(), naive["rpe"].size());
  EXPECT_GE(naive["rpe"].size(), 2u);
  for (std::size_t i = 0; i < naive["rpe"].size(); ++i) {
    ExpectEqualNumbers(ours["rpe"][i], naive["rpe"][i]);
  }
  EXPECT_NEAR(ours["drift_percent"].get<double>(), naive["drift_percent"].get<double>(), 1e-9);
  EXPECT_NEAR(
      ours["scale_error_percent"].get<double>(), naive["scale_error_percent"].get<double>(), 1e-9);
}

// A curve at 200 Hz as truth; as estimate a noisy copy at 20 Hz with other stamps and another
// frame.
void WriteSyntheticPair(const fs::path& estimate_file, const fs::path& truth_file) {
  Rng rng(7);
  const SE3 T_WG(ExpSO3({0.4, -0.2, 1.5}), {3, -2, 1});
  std::vector<StampedPose> truth, estimate;
  const auto pose_at = [](double t) {
    const Vector3d p(4 * std::cos(0.5 * t), 3 * std::sin(0.7 * t), 1 + 0.5 * std::sin(1.1 * t));
    return SE3(ExpSO3({0.3 * std::sin(t), 0.2 * std::cos(1.3 * t), 0.5 * t}), p);
  };
  const std::int64_t start_ns = 1403636584763555584;
  for (int i = 0; i < 4000; ++i) {
    truth.push_back({Timestamp{start_ns + 5'000'000LL * i}, pose_at(0.005 * i)});
    if (i % 10 != 3) continue;
    const SE3 pose = T_WG * pose_at(0.005 * i + 0.0013);
    const SE3 noisy = pose.Retract(0.01 * rng.Normal3(), 0.02 * rng.Normal3());
    estimate.push_back({Timestamp{start_ns + 5'000'000LL * i + 1'300'000}, noisy});
  }
  WriteTum(truth_file, truth);
  WriteTum(estimate_file, estimate);
}

TEST(TrajectoryReferenceTest, AgreesWithNaiveImplementationOnSyntheticData) {
  if (!HasNumpy()) GTEST_SKIP() << kPython << " has no numpy";
  const fs::path folder =
      fs::path(::testing::TempDir()) / ("facet_reference_" + std::to_string(getpid()));
  fs::create_directories(folder);
  WriteSyntheticPair(folder / "estimate.tum", folder / "truth.tum");
  for (AlignmentKind kind : {AlignmentKind::kSE3, AlignmentKind::kYawOnly, AlignmentKind::kSim3}) {
    SCOPED_TRACE(ToString(kind));
    ExpectAgreesWithNaive(folder / "estimate.tum", folder / "truth.tum", kind);
  }
  ExpectAgreesWithNaive(folder / "estimate.tum", folder / "truth.tum", AlignmentKind::kSE3, true);
  fs::remove_all(folder);
}

struct Published {
  const char* file;
  double rmse, mean, median, max;
};

void PrintTo(const Published& published, std::ostream* stream) {
  *stream << published.file;
}

class PublishedEstimateTest : public ::testing::TestWithParam<Published> {
 protected:
  void SetUp() override {
    const auto estimates = testing::DataDir("published_estimates");
    const auto flights = testing::DataDir("euroc_flights");
    if (!estimates || !flights)
      GTEST_SKIP() << testing::MissingData("published_estimates, euroc_flights");
    estimate_ = *estimates / GetParam().file;
    truth_ = *flights / "V1_02_medium" / "groundtruth.csv";
  }

  fs::path estimate_, truth_;
};

TEST_P(PublishedEstimateTest, HasThePublishedErrors) {
  const RunEvaluation evaluation = EvaluateRun(estimate_, LoadGroundTruth(truth_), {});
  const ErrorStatistics& ate = evaluation.causal.ate_m;
  EXPECT_NEAR(ate.rmse, GetParam().rmse, 1e-3);
  EXPECT_NEAR(ate.mean, GetParam().mean, 1e-3);
  EXPECT_NEAR(ate.median, GetParam().median, 1e-3);
  EXPECT_NEAR(ate.max, GetParam().max, 1e-3);
}

TEST_P(PublishedEstimateTest, AgreesWithNaiveImplementation) {
  if (!HasNumpy()) GTEST_SKIP() << kPython << " has no numpy";
  ExpectAgreesWithNaive(estimate_, truth_);
  ExpectAgreesWithNaive(estimate_, truth_, AlignmentKind::kSim3);
}

INSTANTIATE_TEST_SUITE_P(
    V1_02,
    PublishedEstimateTest,
    ::testing::Values(Published{"orbslam_V1_02.tum", 0.0917, 0.0815, 0.0778, 0.2562},
                      Published{"vislam_rp_V1_02_run0.tum", 0.0649, 0.0578, 0.0544, 0.1680}),
    [](const auto& param) { return std::string(param.index == 0 ? "OrbSlam" : "VislamRp"); });

}  // namespace
}  // namespace facet
