// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/patch_tracker.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "facet/base/check.h"

namespace facet {
namespace {

using Row = Eigen::Map<Eigen::Array<float, kPatchSize, 1>, Eigen::Aligned32>;

struct alignas(32) PatchRow {
  std::array<float, kPatchSize> values{};
  float* data() { return values.data(); }
  const float* data() const { return values.data(); }
};

// A disc: the samples in the corners are farther away and say less about the centre's motion.
PatchRow MakeWeights() {
  PatchRow weights;
  for (int r = 0; r < kPatchSide; ++r) {
    for (int c = 0; c < kPatchSide; ++c) {
      const float u = static_cast<float>(c) - kPatchHalf, v = static_cast<float>(r) - kPatchHalf;
      weights.values[static_cast<std::size_t>(r * kPatchSide + c)] = u * u + v * v < 18 ? 1.0F : 0.0F;
    }
  }
  return weights;
}

const PatchRow kWeights = MakeWeights();

constexpr float SumOfWeights() {
  return 52;
}

// Values and central differences of the unrotated patch. Only additions and products per element, so
// any vectorisation gives the same bits.
void SampleWithGradient(const ImageLevel& image, float x, float y, PatchRow& value, PatchRow& gx, PatchRow& gy) {
  constexpr int kSide = kPatchSide + 2;
  const float left = x - kPatchHalf - 1, top = y - kPatchHalf - 1;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = left - static_cast<float>(ix), fy = top - static_cast<float>(iy);
  std::array<std::array<float, kSide>, kSide + 1> rows;
  for (int r = 0; r <= kSide; ++r) {
    const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iy + r) * image.step + ix;
    auto& row = rows[static_cast<std::size_t>(r)];
    for (int c = 0; c < kSide; ++c) {
      const float a = p[c], b = p[c + 1];
      row[static_cast<std::size_t>(c)] = a + fx * (b - a);
    }
  }
  std::array<std::array<float, kSide>, kSide> patch;
  for (std::size_t r = 0; r < kSide; ++r) {
    for (std::size_t c = 0; c < kSide; ++c) {
      patch[r][c] = rows[r][c] + fy * (rows[r + 1][c] - rows[r][c]);
    }
  }
  for (std::size_t r = 0; r < kPatchSide; ++r) {
    for (std::size_t c = 0; c < kPatchSide; ++c) {
      const std::size_t i = r * kPatchSide + c;
      value.values[i] = patch[r + 1][c + 1];
      gx.values[i] = 0.5F * (patch[r + 1][c + 2] - patch[r + 1][c]);
      gy.values[i] = 0.5F * (patch[r + 2][c + 1] - patch[r][c + 1]);
    }
  }
}

struct PatchOffsets {
  PatchRow u, v;
};

PatchOffsets MakeOffsets() {
  PatchOffsets offsets;
  for (int i = 0; i < kPatchSize; ++i) {
    offsets.u.values[static_cast<std::size_t>(i)] = static_cast<float>(i % kPatchSide) - kPatchHalf;
    offsets.v.values[static_cast<std::size_t>(i)] = static_cast<float>(i / kPatchSide) - kPatchHalf;
  }
  return offsets;
}

const PatchOffsets kOffsets = MakeOffsets();

// d template / d (x, y, angle, log scale), one row of samples each; 6 parameters are (x, y) and the
// four entries of the affine matrix.
void FillJacobian(const PatchRow& gx, const PatchRow& gy, int num_parameters, float* rows) {
  for (int i = 0; i < kPatchSize; ++i) {
    const auto s = static_cast<std::size_t>(i);
    const float x = gx.values[s], y = gy.values[s];
    const float u = kOffsets.u.values[s], v = kOffsets.v.values[s];
    rows[i] = x;
    rows[kPatchSize + i] = y;
    if (num_parameters == 6) {
      rows[2 * kPatchSize + i] = x * u;
      rows[3 * kPatchSize + i] = x * v;
      rows[4 * kPatchSize + i] = y * u;
      rows[5 * kPatchSize + i] = y * v;
      continue;
    }
    if (num_parameters >= 3) rows[2 * kPatchSize + i] = y * u - x * v;
    if (num_parameters >= 4) rows[3 * kPatchSize + i] = x * u + y * v;
  }
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

PatchTracker::PatchTracker(const KltOptions& options)
    : options_(options),
      num_parameters_(options.num_parameters),
      kernels_(FindPatchKernels(options.simd)) {
  FACET_CHECK(kernels_ != nullptr) << "simd variant " << options.simd << " cannot run here";
  FACET_CHECK(options.num_levels >= 1 && options.num_levels <= kMaxPyramidLevels);
}

void PatchTracker::Extract(
    const ImagePyramid& image, float x, float y, LevelRange range, PatchPyramid& patch) const {
  for (int l = 0; l < kMaxPyramidLevels; ++l) {
    PatchTemplate& level = patch.levels[static_cast<std::size_t>(l)];
    level.is_valid = false;
    if (l < range.finest || l > range.coarsest || l >= image.num_levels()) continue;
    const float scale = 1.0F / static_cast<float>(1 << l);
    ExtractLevel(image.level(l), x * scale, y * scale, level);
  }
}

void PatchTracker::ExtractLevel(const ImageLevel& image, float x, float y, PatchTemplate& patch) const {
  patch.is_valid = false;
  // One sample more on each side than the patch itself, for the gradient.
  constexpr float kGrow = (kPatchHalf + 1) / kPatchHalf;
  if (!CanSample(image, {kGrow, 0, 0, kGrow, x, y})) return;
  PatchRow value, gx, gy, weighted;
  SampleWithGradient(image, x, y, value, gx, gy);

  const int n = num_parameters_;
  alignas(32) std::array<float, kMaxWarpParameters * kPatchSize> jacobian;
  FillJacobian(gx, gy, n, jacobian.data());
  float sum = 0, squares = 0;
  kernels_->moments(value.data(), kWeights.data(), &sum, &squares);
  const float mean = sum / SumOfWeights();
  Row contrast(value.data());
  const Row weights(const_cast<float*>(kWeights.data()));
  contrast = weights * (contrast - mean);
  float unused = 0, contrast2 = 0;
  kernels_->moments(value.data(), kWeights.data(), &unused, &contrast2);
  // Less than about one grey level of contrast is noise.
  if (!(contrast2 > SumOfWeights())) return;

  // Project offset and gain out of the Jacobian.
  std::array<float, kMaxWarpParameters> on_offset{}, on_gain{};
  kernels_->dot_rows(kWeights.data(), jacobian.data(), n, on_offset.data());
  kernels_->dot_rows(contrast.data(), jacobian.data(), n, on_gain.data());
  using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxWarpParameters, kMaxWarpParameters>;
  Matrix H(n, n);
  for (int k = 0; k < n; ++k) {
    Row row(jacobian.data() + k * kPatchSize);
    const auto s = static_cast<std::size_t>(k);
    row = weights * (row - on_offset[s] / SumOfWeights() - (on_gain[s] / contrast2) * contrast);
  }
  std::array<float, kMaxWarpParameters> products{};
  for (int k = 0; k < n; ++k) {
    kernels_->dot_rows(jacobian.data() + k * kPatchSize, jacobian.data(), k + 1, products.data());
    for (int j = 0; j <= k; ++j) H(k, j) = H(j, k) = products[static_cast<std::size_t>(j)];
  }
  const Eigen::LLT<Matrix> llt(H);
  if (llt.info() != Eigen::Success) return;
  const Matrix inverse = llt.solve(Matrix::Identity(n, n));
  const float xx = inverse(0, 0), xy = inverse(0, 1), yy = inverse(1, 1);
  const float half_trace = 0.5F * (xx + yy);
  const float max_variance = half_trace + std::sqrt(0.25F * (xx - yy) * (xx - yy) + xy * xy);
  if (!(max_variance > 0) || !std::isfinite(max_variance)) return;

  patch.norm = std::sqrt(contrast2);
  patch.translation_cov = half_trace;
  patch.min_eigenvalue = 1 / (max_variance * SumOfWeights());
  Row(patch.rows.data()) = contrast / contrast2;
  for (int k = 0; k < n; ++k) {
    Row row(patch.rows.data() + (1 + k) * kPatchSize);
    row = inverse(k, 0) * Row(jacobian.data());
    for (int j = 1; j < n; ++j) row += inverse(k, j) * Row(jacobian.data() + j * kPatchSize);
  }
  patch.is_valid = true;
}

float PatchTracker::Similarity(const PatchTemplate& patch,
                               const ImageLevel& image,
                               const PatchWarp& warp) const {
  if (!patch.is_valid || !CanSample(image, warp)) return -1;
  PatchRow value;
  kernels_->sample(image, warp, value.data());
  float gain = 0, sum = 0, squares = 0;
  kernels_->dot_rows(value.data(), patch.rows.data(), 1, &gain);
  kernels_->moments(value.data(), kWeights.data(), &sum, &squares);
  const float variance = squares - sum * sum / SumOfWeights();
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
  const PatchWarp start = warp;
  PatchRow value;
  std::array<float, 1 + kMaxWarpParameters> product{};
  const auto min_update2 = static_cast<float>(options_.min_update_px * options_.min_update_px);
  bool converged = false;
  for (int i = 0; i < options_.max_iterations && !converged; ++i) {
    if (!CanSample(image, warp)) return false;
    kernels_->sample(image, warp, value.data());
    kernels_->dot_rows(value.data(), patch.rows.data(), 1 + num_parameters_, product.data());
    const float gain = product[0];
    if (!(gain > kMinGain)) return false;
    std::array<float, kMaxWarpParameters> update{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(num_parameters_); ++k) {
      update[k] = product[k + 1] / gain;
    }
    Compose(update.data(), num_parameters_, warp);
    const float dx = warp.x - start.x, dy = warp.y - start.y;
    if (!(dx * dx + dy * dy < kMaxShift * kMaxShift)) return false;
    converged = update[0] * update[0] + update[1] * update[1] < min_update2;
  }
  if (!CanSample(image, warp)) return false;
  float sum = 0, squares = 0;
  kernels_->moments(value.data(), kWeights.data(), &sum, &squares);
  const float variance = squares - sum * sum / SumOfWeights();
  *zncc = variance > 1 ? product[0] * patch.norm / std::sqrt(variance) : -1;
  return true;
}

Alignment PatchTracker::Align(const PatchPyramid& patch,
                              const ImagePyramid& image,
                              LevelRange range,
                              PatchWarp& warp) const {
  Alignment result;
  PatchWarp refined = warp;
  const int coarsest = std::min(range.coarsest, image.num_levels() - 1);
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
    const float unexplained = std::max(0.0F, 1 - result.zncc * result.zncc);
    const float noise2 = unexplained * level.norm * level.norm /
                         (SumOfWeights() - 2 - static_cast<float>(num_parameters_));
    result.sigma_px = static_cast<float>(1 << l) * std::sqrt(noise2 * level.translation_cov);
  }
  result.ok = true;
  warp = refined;
  return result;
}

}  // namespace facet
