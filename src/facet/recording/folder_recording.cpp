// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/folder_recording.h"

#include <algorithm>

namespace facet {

void FolderRecording::Rewind() {
  next_imu_ = next_frame_ = 0;
}

bool FolderRecording::IsImuNext() const {
  const std::vector<ImuSample>& imu = dataset_.imu();
  if (next_imu_ == imu.size()) return false;
  if (next_imu_ == 0 || next_frame_ == dataset_.frames().size()) return true;
  return imu[next_imu_ - 1].t <= dataset_.frames()[next_frame_].t + dataset_.rig().time_offset;
}

std::optional<RecordingEvent> FolderRecording::Next() {
  if (IsImuNext()) return dataset_.imu()[next_imu_++];
  if (next_frame_ == dataset_.frames().size()) return std::nullopt;
  const FrameEntry& entry = dataset_.frames()[next_frame_++];
  const int bits = dataset_.sample_bits();
  RecordedFrame frame;
  frame.t = entry.t;
  frame.t_right = entry.t_right;
  frame.left = std::make_shared<FileImage>(dataset_.ImagePath(0, entry.left), bits);
  if (entry.HasRight()) {
    frame.right = std::make_shared<FileImage>(dataset_.ImagePath(1, entry.right), bits);
  }
  return frame;
}

int FolderRecording::NumFrames(Timestamp from, Timestamp to) const {
  const auto is_inside = [&](const FrameEntry& frame) { return frame.t >= from && frame.t <= to; };
  return static_cast<int>(std::ranges::count_if(dataset_.frames(), is_inside));
}

}  // namespace facet
