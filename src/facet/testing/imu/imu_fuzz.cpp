// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/imu/imu_fuzz.h"

#include <cmath>
#include <cstdlib>

#include "facet/imu/imu_buffer.h"
#include "facet/imu/preintegration.h"
#include "facet/testing/fuzz_bytes.h"

namespace facet::testing {

namespace {

constexpr Duration kUsualStep{5'000'000};
// Twice that fills the statistics of the screen.
constexpr int kMaxQuietSamples = 127;

// What a byte asks for.
enum Operation {
  kQuietSamples,
  kOddSample,
  kOddStamp,
  kRepeatedSamples,
  kCutAtNewest,
  kCutAnywhere,
  kDrop,
  kNumOperations
};

bool IsFinite(const ImuPreintegration& x) {
  return std::isfinite(x.dt()) && x.dR().coeffs().allFinite() && x.dp().allFinite() &&
         x.dv().allFinite() && x.Covariance().allFinite() && x.BiasJacobian().allFinite();
}

bool IsFinite(const NavState& x) {
  return x.T_WB.q.coeffs().allFinite() && x.T_WB.p.allFinite() && x.v_WB.allFinite();
}

class ImuStream {
 public:
  explicit ImuStream(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::string Run() {
    while (!bytes_.empty() && problem_.empty())
      Act(static_cast<Operation>(bytes_.Index(kNumOperations)));
    return problem_;
  }

 private:
  void Act(Operation operation) {
    switch (operation) {
      case kQuietSamples:
        for (int i = bytes_.Index(kMaxQuietSamples + 1); i >= 0; --i)
          Add(Quiet());
        return;
      case kOddSample:
        return Add(Odd());
      case kOddStamp:
        t_ = bytes_.Flag() ? Timestamp{bytes_.AnyStamp()} : t_ + Duration{bytes_.Integer()};
        return Add(Quiet());
      case kRepeatedSamples:
        for (int i = bytes_.Index(30); i > 0; --i) {
          t_ = t_ + kUsualStep;
          Add({t_, newest_.gyro, newest_.accel});
        }
        return;
      case kCutAtNewest:
        return Cut(t_ - Duration{bytes_.Byte() * kUsualStep.ns / 2},
                   t_ + Duration{bytes_.Index(16) * kUsualStep.ns / 2});
      case kCutAnywhere:
        return Cut({bytes_.AnyStamp()}, {bytes_.AnyStamp()});
      default:
        return buffer_.DropBefore(bytes_.Flag() ? Timestamp{bytes_.AnyStamp()} : t_);
    }
  }

  ImuSample Quiet() {
    t_ = t_ + kUsualStep;
    const double noise = 1e-3 * static_cast<double>(num_added_ * 7919 % 101 - 50);
    return {t_, {noise, 0.1, -noise}, {0.1 * noise, noise, 9.8 + noise}};
  }

  ImuSample Odd() {
    ImuSample sample = Quiet();
    const int axis = bytes_.Index(6);
    const double value = bytes_.Flag() ? bytes_.Real() : bytes_.Near(200);
    (axis < 3 ? sample.gyro : sample.accel)[axis % 3] = value;
    return sample;
  }

  void Add(const ImuSample& sample) {
    newest_ = sample;
    ++num_added_;
    buffer_.Add(sample);
    Require(buffer_.size() <= static_cast<std::size_t>(num_added_), "more samples than were added");
    const ImuScreenCounts& counts = buffer_.screen_counts();
    Require(counts.num_cut >= 0 && counts.num_cut <= num_added_, "more cut than were added");
  }

  void Cut(Timestamp t0, Timestamp t1) {
    const Duration max_gap{bytes_.Byte() * 1'000'000LL};
    if (bytes_.Flag()) buffer_.TimeIsAt(t1);
    const ImuInterval interval = buffer_.Between(t0, t1, max_gap, max_gap);
    Require(interval.gaps >= 0 && interval.longest_gap.ns >= 0, "a hole of negative length");
    if (interval.samples.empty()) return;
    Require(interval.samples.front().t == t0, "the first sample is not at the beginning");
    Require(interval.samples.back().t == t1, "the last sample is not at the end");
    for (std::size_t i = 0; i < interval.samples.size(); ++i)
      CheckSample(interval.samples, i);
    if (problem_.empty()) Integrate(interval);
  }

  void CheckSample(const std::vector<ImuSample>& samples, std::size_t i) {
    const ImuSample& s = samples[i];
    Require(i == 0 || s.t >= samples[i - 1].t, "samples are not in order");
    const double most = std::max(s.gyro.cwiseAbs().maxCoeff(), s.accel.cwiseAbs().maxCoeff());
    Require(most <= ImuBuffer::kMaxMagnitude, "a sample beyond the largest one");
    Require(s.gyro_doubt.allFinite() && s.gyro_doubt.minCoeff() >= 0 && s.accel_doubt.allFinite() &&
                s.accel_doubt.minCoeff() >= 0,
            "a doubt that is none");
  }

  void Integrate(const ImuInterval& interval) {
    const ImuBias bias{Vector3d::Constant(bytes_.Near(1)), Vector3d::Constant(bytes_.Near(1))};
    ImuPreintegration integral(bias, ImuParameters());
    integral.Integrate(interval.samples, {1, ToSeconds(interval.allowed_gap)});
    Require(IsFinite(integral), "the integral is not finite");
    Require(std::abs(integral.dR().norm() - 1) < 1e-6, "the rotation is not of unit norm");
    Require(integral.Covariance().diagonal().minCoeff() >= 0, "a negative variance");
    Require(IsFinite(integral.Predict(NavState())), "the prediction is not finite");
    integral.Reintegrate(ImuBias(), Vector3d::Zero());
    Require(IsFinite(integral), "the integral about another bias is not finite");
  }

  void Require(bool holds, const char* what) {
    if (!holds && problem_.empty()) problem_ = what;
  }

  FuzzBytes bytes_;
  ImuBuffer buffer_;
  Timestamp t_{1'403'636'579'000'000'000};
  ImuSample newest_;
  std::int64_t num_added_ = 0;
  std::string problem_;
};

}  // namespace

std::string FuzzImu(std::span<const std::uint8_t> bytes) {
  return ImuStream(bytes).Run();
}

std::vector<std::vector<std::uint8_t>> ImuFuzzSeeds() {
  const std::vector<std::uint8_t> quiet = {
      kQuietSamples, 120, kQuietSamples, 100, kCutAtNewest, 20, 0, 21, 128, 128};
  std::vector<std::vector<std::uint8_t>> seeds = {quiet};
  const std::vector<std::vector<std::uint8_t>> damages = {
      {kOddSample, 0, 0, 255},
      {kOddSample, 5, 1, 6},
      {kOddStamp, 1, 1},
      {kOddStamp, 0, 0, 0, 0, 0, 255, 255, 255, 255},
      {kRepeatedSamples, 20},
      {kCutAnywhere, 0, 1, 21},
      {kDrop, 0},
  };
  for (const std::vector<std::uint8_t>& damage : damages) {
    seeds.push_back(quiet);
    seeds.back().insert(seeds.back().end(), damage.begin(), damage.end());
    seeds.back().insert(seeds.back().end(), quiet.begin(), quiet.end());
  }
  return seeds;
}

}  // namespace facet::testing
