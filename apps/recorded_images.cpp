// SPDX-License-Identifier: BSD-2-Clause
#include "recorded_images.h"

#include <algorithm>
#include <map>
#include <variant>

#include "facet/io/errors.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/open_recording.h"

namespace facet {

std::shared_ptr<CameraImages> OpenRecordedImages(const std::filesystem::path& recording) {
  if (!std::filesystem::is_directory(recording) || KindOfFolder(recording) == FolderKind::kOther) {
    throw InputError(recording.string() +
                     ": images are shown of folders with image files only (mav0/, KITTI raw, or "
                     "left/ and right/)");
  }
  const std::unique_ptr<Recording> opened = OpenRecording(recording);
  const auto images = std::make_shared<CameraImages>();
  images->rig = opened->calibration()->rig;
  const auto encoded = std::make_shared<std::map<Timestamp, RecordedFrame>>();
  while (auto event = opened->Next()) {
    if (auto* frame = std::get_if<RecordedFrame>(&*event)) {
      frame->right = nullptr;
      encoded->emplace(frame->t, std::move(*frame));
    }
  }
  for (const auto& [t, frame] : *encoded)
    images->stamps.push_back(t);
  const auto decoder = std::make_shared<FrameDecoder>(images->rig);
  images->read = [encoded, decoder](Timestamp t) {
    cv::Mat left, right;
    decoder->Decode(encoded->at(t), left, right);
    return left;
  };
  return images;
}

}  // namespace facet
