// SPDX-License-Identifier: BSD-2-Clause
// How often the way of a frame asks the system for memory once everything is warm. What remains,
// and why, is in docs/notebook/footprint.md.
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "facet/base/median.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/testing/pipeline/painted_recording.h"

// The sanitizers and other C libraries have allocators that cannot be asked this way.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FACET_HAS_SANITIZER 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FACET_HAS_SANITIZER 1
#endif
#if defined(__GLIBC__) && !defined(FACET_HAS_SANITIZER)
#define FACET_COUNTS_ALLOCATIONS 1

namespace {
std::atomic<long> g_num_allocations{0};
}

// NOLINTBEGIN: names of the C library
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* pointer, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  g_num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  g_num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(count, size);
}
void* realloc(void* pointer, std::size_t size) noexcept {
  g_num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(pointer, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  g_num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** pointer, std::size_t alignment, std::size_t size) noexcept {
  g_num_allocations.fetch_add(1, std::memory_order_relaxed);
  *pointer = __libc_memalign(alignment, size);
  return *pointer == nullptr ? ENOMEM : 0;
}
}
// NOLINTEND
#endif

namespace facet {
namespace {

#ifdef FACET_COUNTS_ALLOCATIONS

struct Counts {
  std::vector<double> keyframes, others;
};

Counts CountWhenWarm(VioOptions options) {
  constexpr Duration kWarm{2'000'000'000};
  const testing::PaintedRecording recording = testing::PaintRecording();
  VioPipeline vio(recording.rig, ImuNoise{}, options);
  Counts counts;
  testing::Feed(
      recording,
      [&](const ImuSample& sample) { vio.AddImu(sample); },
      [&](const StereoFrame& frame) {
        const long before = g_num_allocations.load();
        const VioOutput output = vio.AddStereo(frame);
        const auto num = static_cast<double>(g_num_allocations.load() - before);
        if (frame.t - testing::kBegin < kWarm) return;
        (output.is_keyframe ? counts.keyframes : counts.others).push_back(num);
      });
  return counts;
}

double MedianOf(std::vector<double> values, const char* what) {
  const double median = Median(values).value_or(0);
  std::printf("%s: %.0f allocations in the median of %zu frames\n", what, median, values.size());
  return median;
}

TEST(Allocation, TheCounterCounts) {
  const long before = g_num_allocations.load();
  void* volatile some = std::malloc(100);
  std::free(some);
  EXPECT_GE(g_num_allocations.load(), before + 1);
}

TEST(Allocation, AFrameBetweenKeyframesNeedsFew) {
  VioOptions options;
  options.mesh.map.enabled = false;
  const Counts counts = CountWhenWarm(options);
  ASSERT_GE(counts.others.size(), 10U);
  EXPECT_LE(MedianOf(counts.others, "between keyframes"), 30);
}

TEST(Allocation, AKeyframeNeedsSome) {
  const Counts counts = CountWhenWarm(VioOptions{});
  ASSERT_GE(counts.keyframes.size(), 3U);
  EXPECT_LE(MedianOf(counts.keyframes, "keyframes"), 650);
}

#else

TEST(Allocation, IsNotCounted) {
  GTEST_SKIP() << "this allocator cannot be counted: a sanitizer, or another C library than glibc";
}

#endif

}  // namespace
}  // namespace facet
