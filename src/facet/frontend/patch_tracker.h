// SPDX-License-Identifier: BSD-2-Clause
// Inverse-compositional alignment of small patches, free in gain and offset (Baker & Matthews, IJCV
// 2004; the two brightness parameters are projected out of the Jacobian, so one update costs a few
// dot products with precomputed rows).
#pragma once

#include <cstddef>
#include <vector>

#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/patch_kernels.h"

namespace facet {

inline constexpr int kMaxPyramidLevels = 5;
inline constexpr int kMaxWarpParameters = 6;

/// One patch of one pyramid level, ready to be found in other images.
struct PatchTemplate {
  bool is_valid = false;  ///< false: too close to the border or without texture
  float norm = 0;         ///< root of the weighted squared contrast
  float translation_cov =
      0;  ///< variance of the position per variance of a grey value, mean of x and y
  float min_eigenvalue = 0;  ///< of the information on the position, per sample [(grey/px)^2]
  /// Row 0 gives the gain, rows 1.. the update of the warp parameters times the gain. Aligned, in
  /// the memory of a PatchPyramid.
  float* rows = nullptr;
  int num_rows = 0;
};

/// A patch on some levels, taken at one point of one image.
struct PatchPyramid {
  /// With room for the finest so many levels, and for trackers with at most so many parameters.
  explicit PatchPyramid(int num_levels = kMaxPyramidLevels,
                        int num_parameters = kMaxWarpParameters);
  PatchPyramid(PatchPyramid&&) = default;
  PatchPyramid& operator=(PatchPyramid&&) = default;

  std::vector<PatchTemplate> levels;

  void Invalidate() {
    for (PatchTemplate& level : levels)
      level.is_valid = false;
  }
  bool IsValid(int level) const { return levels[static_cast<std::size_t>(level)].is_valid; }

 private:
  struct alignas(32) Row {
    float values[kPatchSize];
  };
  std::vector<Row> rows_;
};

/// The outcome of an alignment.
struct Alignment {
  bool ok = false;     ///< converged inside the image on at least the finest level that was tried
  int level = 0;       ///< finest level that was aligned
  float zncc = -1;     ///< similarity there, -1..1
  float sigma_px = 0;  ///< 1-sigma of the position per axis from the residuals, in level-0 pixels
};

/// The range of levels of an alignment, coarse to fine.
struct LevelRange {
  int coarsest = 0;
  int finest = 0;
};

/// Thread-safe (immutable).
class PatchTracker {
 public:
  /// Free parameters of the warp besides gain and offset: 2 shift, 3 and rotation, 4 and scale, 6
  /// affine. CHECKs these numbers and that options.simd can run here.
  /// An alignment ends when an update moves the patch by less than `min_update_px`.
  PatchTracker(const KltOptions& options, int num_parameters, double min_update_px = 0.01);

  /// Takes the patch around (x, y) of level 0, on those levels of `range` that it has; the others
  /// stay as they are.
  void Extract(
      const ImagePyramid& image, float x, float y, LevelRange range, PatchPyramid& patch) const;

  /// Takes one level; (x, y) in pixels of that level. CHECKs that it has room.
  void ExtractLevel(const ImageLevel& image, float x, float y, PatchTemplate& patch) const;

  /// Refines the warp (in level-0 pixels) from patch to image. Levels where the patch is invalid or
  /// leaves the image are skipped; the finest level must be there and succeed. The warp is
  /// unchanged on failure.
  Alignment Align(const PatchPyramid& patch,
                  const ImagePyramid& image,
                  LevelRange range,
                  PatchWarp& warp) const;

  /// Similarity of the patch with the image under the warp in pixels of that level, -1 if outside.
  float Similarity(const PatchTemplate& patch,
                   const ImageLevel& image,
                   const PatchWarp& warp) const;

  const PatchKernels& kernels() const { return *kernels_; }

 private:
  bool AlignLevel(const PatchTemplate& patch,
                  const ImageLevel& image,
                  PatchWarp& warp,
                  float* zncc) const;

  int num_parameters_;
  float min_update2_;
  const PatchKernels* kernels_;
};

/// The warp in pixels of level l, from level 0, and back.
PatchWarp ToLevel(PatchWarp warp, int level);
PatchWarp FromLevel(PatchWarp warp, int level);

}  // namespace facet
