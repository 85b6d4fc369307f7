// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/asl_dataset.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "facet/io/asl_files.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Removes entries whose image does not exist.
void DropMissingFiles(const fs::path& folder,
                      std::vector<ImageListEntry>& images,
                      std::vector<std::string>& warnings) {
  const std::size_t num_listed = images.size();
  const std::string first = images.front().file;
  std::error_code error;
  std::erase_if(images, [&](const ImageListEntry& image) {
    return !fs::is_regular_file(folder / image.file, error);
  });
  if (images.empty()) {
    throw InputError((folder / first).string() + ": no such file, as all " +
                     std::to_string(num_listed) + " images listed in " +
                     (folder.parent_path() / "data.csv").string());
  }
  if (images.size() < num_listed) {
    warnings.push_back(folder.string() + ": " + std::to_string(num_listed - images.size()) +
                       " of " + std::to_string(num_listed) + " listed images are missing");
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

fs::path FindMav0(const fs::path& sequence) {
  std::error_code error;
  if (!fs::is_directory(sequence, error)) {
    throw InputError(sequence.string() + ": no such folder");
  }
  // A trailing slash would make an empty file name, "." would have no parent.
  fs::path folder = fs::weakly_canonical(sequence, error);
  if (error) folder = sequence;
  if (fs::is_directory(folder / "mav0", error)) return folder / "mav0";
  if (fs::is_directory(folder / "cam0", error)) return folder;
  throw InputError(
      sequence.string() +
      ": holds neither mav0/ nor cam0/; a sequence in the ASL/EuRoC layout is expected");
}

fs::path FindTruth(const fs::path& sequence) {
  const fs::path mav0 = FindMav0(sequence);
  std::error_code error;
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0"}) {
    const fs::path file = mav0 / name / "data.csv";
    if (fs::is_regular_file(file, error)) return file;
  }
  return {};
}

fs::path RequireTruth(const fs::path& sequence) {
  const fs::path file = FindTruth(sequence);
  if (file.empty()) {
    throw InputError(sequence.string() +
                     ": no ground truth; state_groundtruth_estimate0/data.csv, mocap0/data.csv or "
                     "vicon0/data.csv is expected in mav0/");
  }
  return file;
}

AslDataset::AslDataset(const fs::path& sequence, const CalibrationFiles& calibration)
    : mav0_(FindMav0(sequence)),
      name_((mav0_.filename() == "mav0" ? mav0_.parent_path() : mav0_).filename().string()),
      calibration_(FindCalibration(mav0_, calibration)),
      warnings_(calibration_.warnings) {
  PairImages();
  imu_ = ReadImuFile(mav0_ / "imu0" / "data.csv", warnings_);
  CheckOverlap();
  RequireReadablePair();
}

fs::path AslDataset::DataFolder(int camera) const {
  return mav0_ / (camera == 0 ? "cam0" : "cam1") / "data";
}

void AslDataset::PairImages() {
  std::array<std::vector<ImageListEntry>, 2> images;
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path folder = DataFolder(camera);
    images[camera] = ReadImageList(folder.parent_path() / "data.csv", warnings_);
    DropMissingFiles(folder, images[camera], warnings_);
  }
  const auto& [left, right] = images;
  const std::int64_t tolerance_ns = MedianIntervalNs(left) / 8;
  std::size_t next = 0, num_mono = 0, num_pairs = 0;
  for (const ImageListEntry& image : left) {
    const std::size_t partner = FindPartner(image.t, right, tolerance_ns, next);
    const bool is_pair = partner < right.size();
    if (!is_pair && num_pairs == 0) continue;
    frames_.push_back({image.t, image.file, is_pair ? right[partner].file : std::string()});
    ++(is_pair ? num_pairs : num_mono);
  }
  if (num_pairs == 0) {
    throw InputError((mav0_ / "cam1" / "data.csv").string() +
                     ": no right image has the stamp of a left one (left " +
                     Seconds(left.front().t) + " to " + Seconds(left.back().t) + ", right " +
                     Seconds(right.front().t) + " to " + Seconds(right.back().t) + ")");
  }
  const std::size_t num_before = left.size() - num_pairs - num_mono;
  if (num_before > 0) {
    warnings_.push_back(std::to_string(num_before) +
                        " left images before the first stereo pair are not used");
  }
  if (num_mono > 0) {
    warnings_.push_back(std::to_string(num_mono) + " left images have no right image");
  }
  if (right.size() > num_pairs) {
    warnings_.push_back(std::to_string(right.size() - num_pairs) +
                        " right images have no left image");
  }
}

void AslDataset::CheckOverlap() {
  const Duration offset = rig().time_offset;
  const Timestamp first = frames_.front().t + offset, last = frames_.back().t + offset;
  if (imu_.front().t > last || imu_.back().t < first) {
    throw InputError((mav0_ / "imu0" / "data.csv").string() +
                     ": camera and IMU do not overlap in time (camera " + Seconds(first) + " to " +
                     Seconds(last) + ", IMU " + Seconds(imu_.front().t) + " to " +
                     Seconds(imu_.back().t) + "); are the stamps of the same clock and unit?");
  }
  const auto is_outside = [&](const FrameEntry& frame) {
    return frame.t + offset < imu_.front().t || frame.t + offset > imu_.back().t;
  };
  const auto num_outside = std::count_if(frames_.begin(), frames_.end(), is_outside);
  if (num_outside > 0) {
    warnings_.push_back(std::to_string(num_outside) + " frames are outside of the IMU data");
  }
}

void AslDataset::RequireReadablePair() {
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

void AslDataset::ReadImage(int camera, const std::string& file, cv::Mat& image) {
  const fs::path path = DataFolder(camera) / file;
  const CameraModel& model = rig().cameras[camera];
  const cv::Size size = reader_.ReadOfSize(path, {model.width(), model.height()}, image);
  if (size.width != model.width() || size.height != model.height()) {
    throw WrongSizeError(path.string() + ": the image has " + std::to_string(size.width) + " x " +
                         std::to_string(size.height) + " pixels, the calibration of cam" +
                         std::to_string(camera) + " has " + std::to_string(model.width()) + " x " +
                         std::to_string(model.height()) +
                         "; scale the one or recalibrate the other");
  }
}

std::string AslDataset::ReadPair(std::size_t i, cv::Mat& left, cv::Mat& right) {
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
