// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/patch_tracker.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet {
namespace {

using testing::Render;
using testing::WaveTexture;

constexpr int kWidth = 320, kHeight = 240, kLevels = 4;

struct AlignedPatch {
  alignas(32) float values[kPatchSize];
};

cv::Mat NoiseImage(int width, int height, std::uint64_t seed) {
  cv::Mat image(height, width, CV_8UC1);
  Rng rng(seed);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at<unsigned char>(y, x) = static_cast<unsigned char>(rng.Index(256));
    }
  }
  return image;
}

// A similarity about the image centre: second(p) = first(map(p)).
struct Motion {
  double dx = 0, dy = 0, angle = 0, scale = 1;
  Vector2d ToFirst(double x, double y) const {
    const double c = std::cos(angle) / scale, s = std::sin(angle) / scale;
    const double u = x - kWidth / 2.0 - dx, v = y - kHeight / 2.0 - dy;
    return {c * u + s * v + kWidth / 2.0, -s * u + c * v + kHeight / 2.0};
  }
  Vector2d ToSecond(double x, double y) const {
    const double c = std::cos(angle) * scale, s = std::sin(angle) * scale;
    const double u = x - kWidth / 2.0, v = y - kHeight / 2.0;
    return {c * u - s * v + kWidth / 2.0 + dx, s * u + c * v + kHeight / 2.0 + dy};
  }
};

struct Case {
  Motion motion;
  double gain = 1, offset = 0;
  int num_parameters = 4;
};

// Root mean square error over a grid of points, starting from no motion.
double TrackingError(const Case& test, int* failures) {
  const WaveTexture texture(1);
  const auto identity = [](double x, double y) { return Vector2d(x, y); };
  const auto moved = [&](double x, double y) { return test.motion.ToFirst(x, y); };
  ImagePyramid first, second;
  const cv::Mat image0 = Render(texture, kWidth, kHeight, identity);
  const cv::Mat image1 = Render(texture, kWidth, kHeight, moved, test.gain, test.offset);
  first.Build(image0, kLevels);
  second.Build(image1, kLevels);
  const PatchTracker tracker(KltOptions{}, test.num_parameters);
  const auto patch = std::make_unique<PatchPyramid>();
  double sum = 0;
  int count = 0;
  *failures = 0;
  for (int y = 60; y <= kHeight - 60; y += 15) {
    for (int x = 60; x <= kWidth - 60; x += 15) {
      patch->Invalidate();
      tracker.Extract(
          first, static_cast<float>(x), static_cast<float>(y), {kLevels - 1, 0}, *patch);
      PatchWarp warp;
      warp.x = static_cast<float>(x);
      warp.y = static_cast<float>(y);
      const Alignment found = tracker.Align(*patch, second, {kLevels - 1, 0}, warp);
      if (!found.ok || found.zncc < 0.8F) {
        ++*failures;
        continue;
      }
      const Vector2d expected = test.motion.ToSecond(x, y);
      sum += (Vector2d(warp.x, warp.y) - expected).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum / std::max(1, count));
}

TEST(PatchTracker, FollowsSubpixelShiftRotationScaleAndBrightness) {
  const std::vector<Case> cases = {
      {.motion = {.dx = 0.37, .dy = -0.81}, .num_parameters = 2},
      {.motion = {.dx = 3.4, .dy = 5.2}, .num_parameters = 2},
      {.motion = {.dx = 0.6, .dy = 0.3, .angle = 0.08}, .num_parameters = 3},
      {.motion = {.dx = 0.6, .dy = 0.3, .angle = -0.05, .scale = 1.08}},
      {.motion = {.dx = -0.6, .dy = 0.3, .scale = 0.93}, .num_parameters = 6},
      {.motion = {.dx = 0.3, .dy = 0.3}, .gain = 0.7, .offset = 25},
      {.motion = {.dx = 1.3, .dy = 0.3, .angle = 0.05}, .gain = 1.1, .offset = -20},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    int failures = 0;
    EXPECT_LT(TrackingError(cases[i], &failures), 0.05) << "case " << i;
    EXPECT_LE(failures, 4) << "case " << i;
  }
}

TEST(PatchTracker, FindsTheExactPlaceInTheSameImage) {
  int failures = 0;
  EXPECT_LT(TrackingError({}, &failures), 1e-4);
  EXPECT_EQ(failures, 0);
}

TEST(PatchTracker, ReportsTheNoiseOfThePosition) {
  const WaveTexture texture(4);
  const auto identity = [](double x, double y) { return Vector2d(x, y); };
  ImagePyramid first, second;
  const cv::Mat image0 = Render(texture, kWidth, kHeight, identity);
  const cv::Mat image1 = Render(texture, kWidth, kHeight, identity, 1, 0, 1.5);
  first.Build(image0, 1);
  second.Build(image1, 1);
  const PatchTracker tracker(KltOptions{}, 2);
  const auto patch = std::make_unique<PatchPyramid>();
  double squares = 0, claimed = 0;
  for (int y = 20; y < kHeight - 20; y += 9) {
    for (int x = 20; x < kWidth - 20; x += 9) {
      patch->Invalidate();
      tracker.Extract(first, static_cast<float>(x), static_cast<float>(y), {0, 0}, *patch);
      PatchWarp warp;
      warp.x = static_cast<float>(x);
      warp.y = static_cast<float>(y);
      const Alignment found = tracker.Align(*patch, second, {0, 0}, warp);
      ASSERT_TRUE(found.ok);
      if (patch->levels[0].min_eigenvalue < 20) continue;  // on an edge the error is not linear
      const double dx = static_cast<double>(warp.x) - x, dy = static_cast<double>(warp.y) - y;
      squares += 0.5 * (dx * dx + dy * dy);
      claimed += static_cast<double>(found.sigma_px) * found.sigma_px;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / claimed), 1.1, 0.25);
}

TEST(PatchTracker, RefusesFlatAndOutsidePatches) {
  ImagePyramid flat;
  const cv::Mat image(kHeight, kWidth, CV_8UC1, cv::Scalar(80));
  flat.Build(image, 1);
  const PatchTracker tracker(KltOptions{}, 4);
  PatchPyramid pyramid(1, 4);
  PatchTemplate& patch = pyramid.levels.front();
  tracker.ExtractLevel(flat.level(0), 100, 100, patch);
  EXPECT_FALSE(patch.is_valid);
  const cv::Mat noise = NoiseImage(kWidth, kHeight, 3);
  flat.Build(noise, 1);
  tracker.ExtractLevel(flat.level(0), 100, 100, patch);
  EXPECT_TRUE(patch.is_valid);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vector2d> outside = {{2, 100}, {100, 2}, {317, 100}, {100, 237}, {-50, 1e9}};
  for (const Vector2d& p : outside) {
    tracker.ExtractLevel(
        flat.level(0), static_cast<float>(p.x()), static_cast<float>(p.y()), patch);
    EXPECT_FALSE(patch.is_valid) << p.transpose();
  }
  tracker.ExtractLevel(flat.level(0), nan, 100, patch);
  EXPECT_FALSE(patch.is_valid);
  EXPECT_FALSE(CanSample(flat.level(0), {1, 0, 0, 1, nan, 5}));
}

TEST(PatchTracker, APyramidHasRoomForSomeLevelsAndParameters) {
  const cv::Mat noise = NoiseImage(kWidth, kHeight, 3);
  ImagePyramid image;
  image.Build(noise, 3);
  const PatchTracker tracker(KltOptions{}, 4);
  PatchPyramid two_levels(2, 4), few_parameters(2, 3);
  tracker.Extract(image, 100, 100, {2, 0}, two_levels);
  EXPECT_TRUE(two_levels.IsValid(0) && two_levels.IsValid(1));
  PatchWarp warp;
  warp.x = warp.y = 100;
  EXPECT_TRUE(tracker.Align(two_levels, image, {2, 0}, warp).ok);
  EXPECT_FALSE(tracker.Align(two_levels, image, {2, 2}, warp).ok);
  ImagePyramid one_level;
  one_level.Build(noise, 1);
  EXPECT_FALSE(tracker.Align(two_levels, one_level, {1, 1}, warp).ok);
  EXPECT_THROW(tracker.Extract(image, 100, 100, {0, 0}, few_parameters), CheckError);
}

TEST(PatchTracker, ChecksItsOptions) {
  EXPECT_THROW(PatchTracker(KltOptions{}, 5), CheckError);
  KltOptions unknown;
  unknown.simd = "mmx";
  EXPECT_THROW(PatchTracker(unknown, 4), CheckError);
}

// Every kernel of every variant against the portable one, bit by bit.
void ExpectSameBits(const PatchKernels& a, const PatchKernels& b) {
  const cv::Mat noise = NoiseImage(97, 61, 11);
  const ImageLevel image = {noise.data, static_cast<int>(noise.step[0]), noise.cols, noise.rows};
  Rng rng(21);
  constexpr int kRows = 8;
  alignas(32) float rows[kRows * kPatchSize], factors[kRows];
  AlignedPatch out[2][3];
  for (int trial = 0; trial < 2000; ++trial) {
    const auto uniform = [&](double low, double high) {
      return static_cast<float>(rng.Uniform(low, high));
    };
    const PatchWarp warp = {uniform(0.6, 1.5),
                            uniform(-0.4, 0.4),
                            uniform(-0.4, 0.4),
                            uniform(0.6, 1.5),
                            uniform(0, 97),
                            uniform(0, 61)};
    for (float& value : rows)
      value = uniform(-100, 100);
    for (float& value : factors)
      value = uniform(-2, 2);
    if (CanSample(image, warp)) {
      a.sample(image, warp, out[0][0].values);
      b.sample(image, warp, out[1][0].values);
      ASSERT_EQ(std::memcmp(&out[0][0], &out[1][0], sizeof(AlignedPatch)), 0);
    }
    if (const PatchWarp upright = {1, 0, 0, 1, warp.x, warp.y}; CanSample(image, upright)) {
      a.sample_upright(image, warp.x, warp.y, out[0][0].values);
      b.sample_upright(image, warp.x, warp.y, out[1][0].values);
      ASSERT_EQ(std::memcmp(&out[0][0], &out[1][0], sizeof(AlignedPatch)), 0);
      b.sample(image, upright, out[1][1].values);
      for (int i = 0; i < kPatchSize; ++i)
        ASSERT_NEAR(out[1][0].values[i], out[1][1].values[i], 0.02);
    }
    if (CanSampleGradient(image, warp.x, warp.y)) {
      for (int k = 0; k < 2; ++k) {
        const PatchKernels& kernels = k == 0 ? a : b;
        kernels.sample_gradient(
            image, warp.x, warp.y, out[k][0].values, out[k][1].values, out[k][2].values);
      }
      ASSERT_EQ(std::memcmp(out[0], out[1], sizeof(out[0])), 0);
    }
    float dots[2][kRows], sums[2][2];
    for (int k = 0; k < 2; ++k) {
      const PatchKernels& kernels = k == 0 ? a : b;
      kernels.dot_rows(rows, rows, kRows, dots[k]);
      kernels.moments(rows, rows + kPatchSize, &sums[k][0], &sums[k][1]);
      kernels.combine(rows, factors, kRows, out[k][0].values);
    }
    ASSERT_EQ(std::memcmp(dots[0], dots[1], sizeof(dots[0])), 0);
    ASSERT_EQ(std::memcmp(sums[0], sums[1], sizeof(sums[0])), 0);
    ASSERT_EQ(std::memcmp(&out[0][0], &out[1][0], sizeof(AlignedPatch)), 0);
  }
}

TEST(PatchKernels, AllVariantsGiveTheSameBits) {
  const PatchKernels* scalar = FindPatchKernels("scalar");
  ASSERT_NE(scalar, nullptr);
  for (const char* name : {"sse2", "avx2", "neon", "auto"}) {
    const PatchKernels* other = FindPatchKernels(name);
    if (other == nullptr) continue;  // not on this machine
    SCOPED_TRACE(name);
    ExpectSameBits(*scalar, *other);
  }
  EXPECT_EQ(FindPatchKernels("mmx"), nullptr);
}

TEST(PatchKernels, SampleTouchesNothingOutsideTheImage) {
  // The allocation ends with the last pixel; a sanitizer sees what reads beyond it.
  const auto pixels = std::make_unique<std::uint8_t[]>(40 * 30);
  for (int i = 0; i < 40 * 30; ++i)
    pixels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i);
  const ImageLevel image = {pixels.get(), 40, 40, 30};
  AlignedPatch out[3];
  for (const char* name : {"scalar", "sse2", "avx2", "neon"}) {
    const PatchKernels* kernels = FindPatchKernels(name);
    if (kernels == nullptr) continue;
    for (float y = 0; y < 30; y += 0.25F) {
      for (float x = 0; x < 40; x += 0.25F) {
        const PatchWarp warp = {1, 0, 0, 1, x, y};
        if (CanSample(image, warp)) {
          kernels->sample(image, warp, out[0].values);
          kernels->sample_upright(image, x, y, out[1].values);
        }
        if (!CanSampleGradient(image, x, y)) continue;
        kernels->sample_gradient(image, x, y, out[0].values, out[1].values, out[2].values);
      }
    }
  }
}

}  // namespace
}  // namespace facet
