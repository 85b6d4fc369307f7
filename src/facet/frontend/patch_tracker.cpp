// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/patch_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "facet/base/check.h"

namespace facet {
namespace {

struct alignas(32) PatchRow {
  std::array<float, kPatchSize> values{};
  float* data() { return values.data(); }
  const float* data() const { return values.data(); }
};

// A disc: the samples in the corners are farther away and say less about the centre's motion.
constexpr PatchRow MakeWeights() {
  PatchRow weights;
  for (int i = 0; i < kPatchSize; ++i) {
    const float u = static_cast<float>(i % kPatchSide) - kPatchHalf;
    const float v = static_cast<float>(i / kPatchSide) - kPatchHalf;
    weights.values[static_cast<std::size_t>(i)] = u * u + v * v < 18 ? 1.0F : 0.0F;
  }
  return weights;
}

constexpr float Sum(const PatchRow& row) {
  float sum = 0;
  for (const float value : row.values)
    sum += value;
  return sum;
}

constexpr PatchRow kWeights = MakeWeights();
constexpr float kWeightSum = Sum(kWeights);

// d template / d (x, y, angle, log scale), one row of samples each; 6 parameters are (x, y) and the
// four entries of the affine matrix. The first two rows are there already, without weights.
template <int N>
void FillJacobian(float* rows) {
  float* const gx = rows;
  float* const gy = rows + kPatchSize;
  for (int i = 0; i < kPatchSize; ++i) {
    gx[i] *= kWeights.data()[i];
    gy[i] *= kWeights.data()[i];
  }
  for (int r = 0; r < kPatchSide; ++r) {
    const float v = static_cast<float>(r) - kPatchHalf;
    for (int c = 0; c < kPatchSide; ++c) {
      const float u = static_cast<float>(c) - kPatchHalf;
      const int i = r * kPatchSide + c;
      if constexpr (N == 6) {
        rows[2 * kPatchSize + i] = gx[i] * u;
        rows[3 * kPatchSize + i] = gx[i] * v;
        rows[4 * kPatchSize + i] = gy[i] * u;
        rows[5 * kPatchSize + i] = gy[i] * v;
      } else {
        if constexpr (N >= 3) rows[2 * kPatchSize + i] = gy[i] * u - gx[i] * v;
        if constexpr (N >= 4) rows[3 * kPatchSize + i] = gx[i] * u + gy[i] * v;
      }
    }
  }
}

// Extracts one level with N free parameters. With J the Jacobian, 1 the offset and T the contrast,
// the update rows are H^-1 J'^T, where J' is J without its parts along 1 and T, and H = J'^T J'.
template <int N>
void ExtractTemplate(
    const PatchKernels& kernels, const ImageLevel& image, float x, float y, PatchTemplate& patch) {
  // Rows: Jacobian, contrast, offset. All are weighted; the weights are 0 or 1.
  alignas(32) std::array<float, (N + 2) * kPatchSize> rows;
  float* const contrast = rows.data() + N * kPatchSize;
  float* const ones = contrast + kPatchSize;
  std::copy(kWeights.values.begin(), kWeights.values.end(), ones);
  PatchRow value;
  kernels.sample_gradient(image, x, y, value.data(), rows.data(), rows.data() + kPatchSize);
  FillJacobian<N>(rows.data());
  float sum = 0, squares = 0;
  kernels.moments(value.data(), ones, &sum, &squares);
  const float mean = sum / kWeightSum;
  for (int i = 0; i < kPatchSize; ++i)
    contrast[i] = ones[i] * (value.data()[i] - mean);

  std::array<float, N + 2> on_contrast{}, on_offset{}, products{};
  kernels.dot_rows(contrast, rows.data(), N + 1, on_contrast.data());
  kernels.dot_rows(ones, rows.data(), N, on_offset.data());
  const float contrast2 = on_contrast[N];
  // Less than about one grey level of contrast is noise.
  if (!(contrast2 > kWeightSum)) return;
  Eigen::Matrix<float, N, N> H;
  for (int k = 0; k < N; ++k) {
    const auto sk = static_cast<std::size_t>(k);
    kernels.dot_rows(rows.data() + k * kPatchSize, rows.data(), k + 1, products.data());
    for (int j = 0; j <= k; ++j) {
      const auto sj = static_cast<std::size_t>(j);
      H(k, j) = H(j, k) = products[sj] - on_offset[sk] * on_offset[sj] / kWeightSum -
                          on_contrast[sk] * on_contrast[sj] / contrast2;
    }
  }
  const Eigen::LLT<Eigen::Matrix<float, N, N>> llt(H);
  if (llt.info() != Eigen::Success) return;
  // Column by column: for a vector Eigen unrolls the solve, for a matrix it packs and blocks.
  Eigen::Matrix<float, N, N> inverse;
  for (int k = 0; k < N; ++k)
    inverse.col(k) = llt.solve(Eigen::Matrix<float, N, 1>::Unit(k));
  const float xx = inverse(0, 0), xy = inverse(0, 1), yy = inverse(1, 1);
  const float half_trace = 0.5F * (xx + yy);
  const float max_variance = half_trace + std::sqrt(0.25F * (xx - yy) * (xx - yy) + xy * xy);
  if (!(max_variance > 0) || !std::isfinite(max_variance)) return;

  patch.norm = std::sqrt(contrast2);
  patch.translation_cov = half_trace;
  patch.min_eigenvalue = 1 / (max_variance * kWeightSum);
  const float to_gain = 1 / contrast2;
  kernels.combine(contrast, &to_gain, 1, patch.rows);
  for (int k = 0; k < N; ++k) {
    std::array<float, N + 2> factors{};
    for (int j = 0; j < N; ++j) {
      const auto sj = static_cast<std::size_t>(j);
      factors[sj] = inverse(k, j);
      factors[N] -= inverse(k, j) * on_contrast[sj] / contrast2;
      factors[N + 1] -= inverse(k, j) * on_offset[sj] / kWeightSum;
    }
    kernels.combine(rows.data(), factors.data(), N + 2, patch.rows + (1 + k) * kPatchSize);
  }
  patch.is_valid = true;
}

// warp <- warp o W(d)^-1 with W(d) u = (I + D) u + (d0, d1).
void Compose(const float* d, int num_parameters, PatchWarp& warp) {
  float m00 = 1, m01 = 0, m10 = 0, m11 = 1;
  if (num_parameters == 6) {
    m00 += d[2], m01 += d[3], m10 += d[4], m11 += d[5];
  } else if (num_parameters >= 3) {
    const float scale = num_parameters >= 4 ? 1 + d[3] : 1.0F;
    // cos and sin to second order: exactly the same on every machine.
    const float c = scale * (1 - 0.5F * d[2] * d[2]), s = scale * d[2];
    m00 = c, m01 = -s, m10 = s, m11 = c;
  }
  const float inverse_det = 1 / (m00 * m11 - m01 * m10);
  const float i00 = m11 * inverse_det, i01 = -m01 * inverse_det;
  const float i10 = -m10 * inverse_det, i11 = m00 * inverse_det;
  const PatchWarp old = warp;
  warp.a00 = old.a00 * i00 + old.a01 * i10;
  warp.a01 = old.a00 * i01 + old.a01 * i11;
  warp.a10 = old.a10 * i00 + old.a11 * i10;
  warp.a11 = old.a10 * i01 + old.a11 * i11;
  warp.x = old.x - (warp.a00 * d[0] + warp.a01 * d[1]);
  warp.y = old.y - (warp.a10 * d[0] + warp.a11 * d[1]);
}

}  // namespace

PatchPyramid::PatchPyramid(int num_levels, int num_parameters)
    : levels(static_cast<std::size_t>(num_levels)),
      rows_(static_cast<std::size_t>(num_levels * (1 + num_parameters))) {
  static_assert(sizeof(Row) == kPatchSize * sizeof(float), "rows follow each other");
  for (std::size_t l = 0; l < levels.size(); ++l) {
    levels[l].num_rows = 1 + num_parameters;
    levels[l].rows = reinterpret_cast<float*>(rows_.data()) +
                     l * static_cast<std::size_t>(levels[l].num_rows * kPatchSize);
  }
}

PatchWarp ToLevel(PatchWarp warp, int level) {
  const float scale = 1.0F / static_cast<float>(1 << level);
  warp.x *= scale;
  warp.y *= scale;
  return warp;
}

PatchWarp FromLevel(PatchWarp warp, int level) {
  const float scale = static_cast<float>(1 << level);
  warp.x *= scale;
  warp.y *= scale;
  return warp;
}

PatchTracker::PatchTracker(const KltOptions& options, int num_parameters, double min_update_px)
    : num_parameters_(num_parameters),
      min_update2_(static_cast<float>(min_update_px * min_update_px)),
      kernels_(FindPatchKernels(options.simd)) {
  FACET_CHECK(kernels_ != nullptr) << "simd variant " << options.simd << " cannot run here";
  FACET_CHECK((num_parameters >= 2 && num_parameters <= 4) || num_parameters == 6)
      << num_parameters;
  FACET_CHECK(options.num_levels >= 1 && options.num_levels <= kMaxPyramidLevels);
}

void PatchTracker::Extract(
    const ImagePyramid& image, float x, float y, LevelRange range, PatchPyramid& patch) const {
  const int num_levels = std::min(image.num_levels(), static_cast<int>(patch.levels.size()));
  for (int l = range.finest; l <= std::min(range.coarsest, num_levels - 1); ++l) {
    const float scale = 1.0F / static_cast<float>(1 << l);
    ExtractLevel(image.level(l), x * scale, y * scale, patch.levels[static_cast<std::size_t>(l)]);
  }
}

void PatchTracker::ExtractLevel(const ImageLevel& image,
                                float x,
                                float y,
                                PatchTemplate& patch) const {
  FACET_CHECK(patch.num_rows > num_parameters_) << patch.num_rows << " rows";
  patch.is_valid = false;
  if (!CanSampleGradient(image, x, y)) return;
  switch (num_parameters_) {
    case 2:
      return ExtractTemplate<2>(*kernels_, image, x, y, patch);
    case 3:
      return ExtractTemplate<3>(*kernels_, image, x, y, patch);
    case 4:
      return ExtractTemplate<4>(*kernels_, image, x, y, patch);
    default:
      return ExtractTemplate<6>(*kernels_, image, x, y, patch);
  }
}

float PatchTracker::Similarity(const PatchTemplate& patch,
                               const ImageLevel& image,
                               const PatchWarp& warp) const {
  if (!patch.is_valid || !CanSample(image, warp)) return -1;
  PatchRow value;
  kernels_->sample(image, warp, value.data());
  float gain = 0, sum = 0, squares = 0;
  kernels_->dot_rows(value.data(), patch.rows, 1, &gain);
  kernels_->moments(value.data(), kWeights.data(), &sum, &squares);
  const float variance = squares - sum * sum / kWeightSum;
  return variance > 1 ? gain * patch.norm / std::sqrt(variance) : -1;
}

bool PatchTracker::AlignLevel(const PatchTemplate& patch,
                              const ImageLevel& image,
                              PatchWarp& warp,
                              float* zncc) const {
  // Farther than this from the start the linearisation means nothing.
  constexpr float kMaxShift = 0.75F * kPatchSide;
  // Smaller gains amplify noise into steps.
  constexpr float kMinGain = 0.1F;
  // Most patches need two or three; the few that need more than six rarely converge.
  constexpr int kMaxIterations = 6;
  const PatchWarp start = warp;
  const bool is_upright = num_parameters_ == 2 && IsUpright(warp);  // and stays so
  PatchRow value;
  std::array<float, 1 + kMaxWarpParameters> product{};
  bool converged = false;
  for (int i = 0; i < kMaxIterations && !converged; ++i) {
    if (!CanSample(image, warp)) return false;
    if (is_upright) {
      kernels_->sample_upright(image, warp.x, warp.y, value.data());
    } else {
      kernels_->sample(image, warp, value.data());
    }
    kernels_->dot_rows(value.data(), patch.rows, 1 + num_parameters_, product.data());
    const float gain = product[0];
    if (!(gain > kMinGain)) return false;
    std::array<float, kMaxWarpParameters> update{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(num_parameters_); ++k) {
      update[k] = product[k + 1] / gain;
    }
    Compose(update.data(), num_parameters_, warp);
    const float dx = warp.x - start.x, dy = warp.y - start.y;
    if (!(dx * dx + dy * dy < kMaxShift * kMaxShift)) return false;
    converged = update[0] * update[0] + update[1] * update[1] < min_update2_;
  }
  if (!CanSample(image, warp)) return false;
  float sum = 0, squares = 0;
  kernels_->moments(value.data(), kWeights.data(), &sum, &squares);
  const float variance = squares - sum * sum / kWeightSum;
  *zncc = variance > 1 ? product[0] * patch.norm / std::sqrt(variance) : -1;
  return true;
}

Alignment PatchTracker::Align(const PatchPyramid& patch,
                              const ImagePyramid& image,
                              LevelRange range,
                              PatchWarp& warp) const {
  Alignment result;
  PatchWarp refined = warp;
  const int num_levels = std::min(image.num_levels(), static_cast<int>(patch.levels.size()));
  const int coarsest = std::min(range.coarsest, num_levels - 1);
  if (coarsest < range.finest) return result;
  for (int l = coarsest; l >= range.finest; --l) {
    const PatchTemplate& level = patch.levels[static_cast<std::size_t>(l)];
    const ImageLevel& pixels = image.level(l);
    PatchWarp w = ToLevel(refined, l);
    if (!level.is_valid || !CanSample(pixels, w)) {
      if (l == range.finest) return result;
      continue;
    }
    if (!AlignLevel(level, pixels, w, &result.zncc)) {
      if (l == range.finest) return result;
      continue;
    }
    refined = FromLevel(w, l);
    result.level = l;
    // Interpolation between pixels hides this much of their noise from the residuals, on average
    // over the places between pixels.
    constexpr float kHidden = 1.5F;
    const float unexplained = std::max(0.0F, 1 - result.zncc * result.zncc);
    const float noise2 = kHidden * kHidden * unexplained * level.norm * level.norm /
                         (kWeightSum - 2 - static_cast<float>(num_parameters_));
    result.sigma_px = static_cast<float>(1 << l) * std::sqrt(noise2 * level.translation_cov);
  }
  result.ok = true;
  warp = refined;
  return result;
}

}  // namespace facet
