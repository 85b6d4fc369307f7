// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/stereo_dataset.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "facet/io/errors.h"
#include "facet/io/sample_depth.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Removes images whose file does not exist.
void DropMissingFiles(ImageFolder& camera, std::vector<std::string>& warnings) {
  const std::size_t num_listed = camera.images.size();
  const std::string first = camera.images.front().file;
  std::error_code error;
  std::erase_if(camera.images, [&](const ImageListEntry& image) {
    return !fs::is_regular_file(camera.folder / image.file, error);
  });
  if (camera.images.empty()) {
    throw InputError((camera.folder / first).string() + ": no such file, as all " +
                     std::to_string(num_listed) + " images listed in " + camera.list.string());
  }
  if (camera.images.size() < num_listed) {
    warnings.push_back(camera.folder.string() + ": " +
                       std::to_string(num_listed - camera.images.size()) + " of " +
                       std::to_string(num_listed) + " listed images are missing");
  }
}

std::int64_t MedianIntervalNs(const std::vector<ImageListEntry>& images) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < images.size(); ++i) {
    intervals.push_back(images[i].t.ns - images[i - 1].t.ns);
  }
  if (intervals.empty()) return 50000000;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

/// The nearest right image within the tolerance, or right.size(). `next` only moves forward.
std::size_t FindPartner(Timestamp t,
                        const std::vector<ImageListEntry>& right,
                        std::int64_t tolerance_ns,
                        std::size_t& next) {
  while (next < right.size() && right[next].t.ns < t.ns - tolerance_ns)
    ++next;
  if (next == right.size() || right[next].t.ns > t.ns + tolerance_ns) return right.size();
  while (next + 1 < right.size() &&
         std::llabs(right[next + 1].t.ns - t.ns) < std::llabs(right[next].t.ns - t.ns)) {
    ++next;
  }
  return next++;
}

/// An image that is not of the calibrated size.
struct WrongSizeError : InputError {
  using InputError::InputError;
};

std::string Seconds(Timestamp t) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.3f s", static_cast<double>(t.ns) * 1e-9);
  return text;
}

}  // namespace

StereoDataset::StereoDataset(RecordingFiles files) : files_(std::move(files)) {
  for (ImageFolder& camera : files_.cameras)
    DropMissingFiles(camera, files_.warnings);
  PairImages();
  CheckOverlap();
  FindSampleBits();
  RequireReadablePair();
  // Runs have readers of their own, and its buffers are as large as images.
  reader_ = ImageReader();
}

void StereoDataset::PairImages() {
  const std::vector<ImageListEntry>&left = files_.cameras[0].images,
        &right = files_.cameras[1].images;
  const std::int64_t tolerance_ns = MedianIntervalNs(left) / 8;
  std::size_t next = 0, num_mono = 0, num_pairs = 0;
  for (const ImageListEntry& image : left) {
    const std::size_t partner = FindPartner(image.t, right, tolerance_ns, next);
    const bool is_pair = partner < right.size();
    if (!is_pair && num_pairs == 0) continue;
    frames_.push_back({image.t,
                       is_pair ? right[partner].t : image.t,
                       image.file,
                       is_pair ? right[partner].file : std::string()});
    ++(is_pair ? num_pairs : num_mono);
  }
  if (num_pairs == 0) {
    throw InputError(files_.cameras[1].list.string() +
                     ": no right image has the stamp of a left one (left " +
                     Seconds(left.front().t) + " to " + Seconds(left.back().t) + ", right " +
                     Seconds(right.front().t) + " to " + Seconds(right.back().t) + ")");
  }
  const std::size_t num_before = left.size() - num_pairs - num_mono;
  if (num_before > 0) {
    files_.warnings.push_back(std::to_string(num_before) +
                              " left images before the first stereo pair are not used");
  }
  if (num_mono > 0) {
    files_.warnings.push_back(std::to_string(num_mono) + " left images have no right image");
  }
  if (right.size() > num_pairs) {
    files_.warnings.push_back(std::to_string(right.size() - num_pairs) +
                              " right images have no left image");
  }
}

void StereoDataset::CheckOverlap() {
  const Duration offset = rig().time_offset;
  const Timestamp first = frames_.front().t + offset, last = frames_.back().t + offset;
  if (imu().front().t > last || imu().back().t < first) {
    throw InputError(files_.imu_file.string() + ": camera and IMU do not overlap in time (camera " +
                     Seconds(first) + " to " + Seconds(last) + ", IMU " + Seconds(imu().front().t) +
                     " to " + Seconds(imu().back().t) +
                     "); are the stamps of the same clock and unit?");
  }
  const auto is_outside = [&](const FrameEntry& frame) {
    return frame.t + offset < imu().front().t || frame.t + offset > imu().back().t;
  };
  const auto num_outside = std::count_if(frames_.begin(), frames_.end(), is_outside);
  if (num_outside > 0) {
    files_.warnings.push_back(std::to_string(num_outside) + " frames are outside of the IMU data");
  }
}

void StereoDataset::FindSampleBits() {
  constexpr std::size_t kNumImages = 10;
  std::uint16_t largest = 0;
  for (std::size_t i = 0; i < kNumImages; ++i) {
    const FrameEntry& frame = frames_[i * (frames_.size() - 1) / (kNumImages - 1)];
    try {
      largest = std::max(largest, reader_.LargestSample(ImagePath(0, frame.left)));
    } catch (const InputError&) {
      // Reported where its frame is used.
    }
  }
  if (largest == 0) return;
  sample_bits_ = UsedSampleBits(largest);
  if (sample_bits_ < 16) files_.warnings.push_back(SampleBitsWarning(sample_bits_, largest));
}

void StereoDataset::RequireReadablePair() {
  constexpr int kMaxWrongSizes = 5;
  cv::Mat left, right;
  std::string first_problem;
  int num_wrong_sizes = 0;
  for (std::size_t i = 0; i < frames_.size() && num_wrong_sizes < kMaxWrongSizes; ++i) {
    std::string problem;
    try {
      problem = ReadPair(i, left, right);
      if (!right.empty()) return;
    } catch (const WrongSizeError& error) {
      // No damage but the wrong calibration: no need to read them all.
      problem = error.what();
      ++num_wrong_sizes;
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (first_problem.empty()) first_problem = problem;
  }
  throw InputError(first_problem + (num_wrong_sizes < kMaxWrongSizes
                                        ? " (and no other stereo pair can be read)"
                                        : ""));
}

void StereoDataset::ReadImage(int camera, const std::string& file, cv::Mat& image) {
  const fs::path path = ImagePath(camera, file);
  const CameraModel& model = rig().cameras[camera];
  const cv::Size size =
      reader_.ReadOfSize(path, {model.width(), model.height()}, image, sample_bits_);
  if (size.width != model.width() || size.height != model.height()) {
    throw WrongSizeError(path.string() + ": the image has " + std::to_string(size.width) + " x " +
                         std::to_string(size.height) + " pixels, the calibration of cam" +
                         std::to_string(camera) + " has " + std::to_string(model.width()) + " x " +
                         std::to_string(model.height()) +
                         "; scale the one or recalibrate the other");
  }
}

std::string StereoDataset::ReadPair(std::size_t i, cv::Mat& left, cv::Mat& right) {
  const FrameEntry& frame = frames_.at(i);
  ReadImage(0, frame.left, left);
  if (!frame.HasRight()) {
    right.release();
    return {};
  }
  try {
    ReadImage(1, frame.right, right);
  } catch (const InputError& error) {
    right.release();
    return error.what();
  }
  return {};
}

}  // namespace facet
