// SPDX-License-Identifier: BSD-2-Clause
// Of the cameras: images that are missing, repeated, badly exposed, or show what they should not.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "facet/base/random.h"
#include "facet/faults/fault_kind.h"
#include "facet/faults/image_edits.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

void FreezeCamera(const FaultValues& value, RecordingCopy& recording) {
  const FaultSpan span = SpanOf(value, recording);
  for (const std::size_t camera : CamerasOf(value)) {
    std::optional<std::filesystem::path> kept;
    for (RecordedImage& image : recording.images[camera]) {
      if (!span.Has(image.t)) continue;
      if (!kept) kept = image.file;
      image.file = *kept;
    }
  }
}

void RepeatImages(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  std::vector<RecordedImage>& left = recording.images[0];
  for (std::size_t i = 1; i < left.size(); ++i) {
    if (rng.Uniform() >= value.at("share")) continue;
    for (auto& images : recording.images) {
      if (i < images.size()) images[i].file = images[i - 1].file;
    }
  }
}

// An old buffer is handed out in place of the image.
void SendOlder(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  const auto back = static_cast<std::size_t>(std::max(1.0, value.at("back")));
  const auto recorded = recording.images;
  for (std::size_t i = back; i < recorded[0].size(); ++i) {
    if (rng.Uniform() >= value.at("share")) continue;
    for (std::size_t camera = 0; camera < recorded.size(); ++camera) {
      if (i < recorded[camera].size())
        recording.images[camera][i].file = recorded[camera][i - back].file;
    }
  }
}

// Two neighbours in time, with the stamps of each other.
void ExchangeImages(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  for (std::size_t i = 1; i < recording.images[0].size(); ++i) {
    if (rng.Uniform() >= value.at("share")) continue;
    for (auto& images : recording.images) {
      if (i < images.size()) std::swap(images[i].file, images[i - 1].file);
    }
    ++i;
  }
}

void DropImages(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  std::map<std::int64_t, bool> is_dropped;
  for (const RecordedImage& image : recording.images[0])
    is_dropped[image.t.ns] = rng.Uniform() < value.at("share");
  for (auto& images : recording.images) {
    images.erase(std::remove_if(images.begin(),
                                images.end(),
                                [&](const RecordedImage& image) { return is_dropped[image.t.ns]; }),
                 images.end());
  }
}

void CutCamera(const FaultValues& value, RecordingCopy& recording) {
  for (const std::size_t camera : CamerasOf(value))
    Erase(recording.images[camera], SpanOf(value, recording));
}

void Pause(const FaultValues& value, RecordingCopy& recording) {
  const FaultSpan span = SpanOf(value, recording);
  Erase(recording.imu, span);
  for (auto& images : recording.images)
    Erase(images, span);
}

void Blacken(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Filled(static_cast<int>(value.at("grey")));
  });
}

void Overexpose(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Brightened(value.at("gain"));
  });
}

void CoverLens(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Covered(value.at("share"));
  });
}

void AddNoise(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage& image, std::size_t camera) {
    return Noisy(value.at("sigma"), static_cast<std::uint64_t>(image.t.ns) + camera);
  });
}

void PassBy(const FaultValues& value, RecordingCopy& recording) {
  const FaultSpan span = SpanOf(value, recording);
  const StereoRig rig = recording.rig;
  EditImages(value, recording, [&](const RecordedImage& image, std::size_t camera) {
    const double tau = ToSeconds(image.t - span.begin) / value.at("crossing");
    const double phase = 0.5 - 0.5 * std::cos(std::numbers::pi * tau);
    return WithBoard(rig, camera, value.at("share"), value.at("depth"), phase);
  });
}

// -------------------------------------------------------------------- exposure, focus, what is
// seen

void Underexpose(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return DarkenedTo(value.at("mean"));
  });
}

void Saturate(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return ClippedAtTop(value.at("share"));
  });
}

// Every other image is darker, as with lamps that beat against the exposure.
void Flicker(const FaultValues& value, RecordingCopy& recording) {
  for (auto& images : recording.images) {
    for (std::size_t i = 1; i < images.size(); i += 2)
      images[i].edits.push_back(Brightened(1 - value.at("change")));
  }
}

void Defocus(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Blurred(value.at("sigma"));
  });
}

void TakeContrast(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Faded(value.at("contrast"));
  });
}

void ProjectDots(const FaultValues& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t camera) {
    return Dotted(value.at("grey"), static_cast<int>(value.at("dots")), camera);
  });
}

// A collision turns a camera in its mount, for good.
void KnockCamera(const FaultValues& value, RecordingCopy& recording) {
  Vector3d turn = Vector3d::Zero();
  turn[static_cast<Eigen::Index>(value.at("axis"))] = value.at("deg") * kDegree;
  std::array<ImageEdit, 2> edits;
  for (const std::size_t camera : CamerasOf(value))
    edits[camera] = Turned(recording.exact_rig.cameras[camera], ExpSO3(turn).toRotationMatrix());
  EditImages(
      value, recording, [&](const RecordedImage&, std::size_t camera) { return edits[camera]; });
}

// The first image again and again, with noise of its own, and an IMU that feels gravity alone.
void StandStill(const FaultValues& value, RecordingCopy& recording) {
  const Timestamp begin = recording.images[0].front().t;
  const double length_s = ToSeconds(recording.images[0].back().t - begin);
  const Timestamp end = begin + FromSeconds(value.at("share") * length_s);
  for (auto& images : recording.images) {
    for (RecordedImage& image : images) {
      if (image.t >= end) continue;
      image.file = images.front().file;
      image.edits.push_back(Noisy(2, static_cast<std::uint64_t>(image.t.ns)));
    }
  }
  Rng rng(3);
  const Vector3d force = kGravity * recording.imu.front().accel.normalized();
  for (ImuSample& sample : recording.imu) {
    if (sample.t >= end) continue;
    sample.gyro = 0.002 * rng.Normal3();
    sample.accel = force + 0.03 * rng.Normal3();
  }
}

}  // namespace

std::vector<FaultKind> ImageFaults() {
  return {
      {"frozen",
       {{"at", 5}, {"length", 0.5}, {"camera", 2}},
       "the cameras repeat one image (camera: 0 left, 1 right, 2 both)",
       FreezeCamera},
      {"repeated",
       {{"share", 0.1}, {"seed", 1}},
       "images that repeat the one before",
       RepeatImages},
      {"older",
       {{"share", 0.1}, {"back", 10}, {"seed", 1}},
       "images that are those of `back` frames before",
       SendOlder},
      {"exchanged",
       {{"share", 0.1}, {"seed", 1}},
       "images that have changed places with the one before",
       ExchangeImages},
      {"dropped", {{"share", 0.3}, {"seed", 1}}, "images that are missing", DropImages},
      {"no_camera",
       {{"at", 5}, {"length", 3}, {"camera", 1}},
       "a camera sends nothing (camera as for frozen)",
       CutCamera},
      {"pause", {{"at", 5}, {"length", 1}}, "no sensor sends anything", Pause},
      {"black",
       {{"at", 5}, {"length", 1}, {"camera", 2}, {"grey", 0}},
       "images of one grey value",
       Blacken},
      {"overexposed",
       {{"at", 5}, {"length", 1}, {"camera", 2}, {"gain", 4}},
       "pixels times the gain, clipped",
       Overexpose},
      {"covered",
       {{"at", 5}, {"length", 3}, {"camera", 2}, {"share", 0.5}},
       "the lower part of the lens is covered",
       CoverLens},
      {"noisy",
       {{"at", 5}, {"length", 3}, {"camera", 2}, {"sigma", 20}},
       "white noise on the pixels",
       AddNoise},
      {"object",
       {{"at", 5}, {"length", 3}, {"camera", 2}, {"share", 0.25}, {"depth", 1.2}, {"crossing", 3}},
       "a board that covers a share of the image moves across it in `crossing` seconds",
       PassBy},
      {"underexposed",
       {{"at", 0}, {"length", 1e6}, {"camera", 2}, {"mean", 12}},
       "images with this mean",
       Underexpose},
      {"clipped",
       {{"at", 0}, {"length", 1e6}, {"camera", 2}, {"share", 0.3}},
       "this share of the pixels is at the upper end",
       Saturate},
      {"flicker", {{"change", 0.2}}, "every other image is darker by this share", Flicker},
      {"blurred",
       {{"at", 0}, {"length", 1e6}, {"camera", 2}, {"sigma", 3}},
       "out of focus [px]",
       Defocus},
      {"faded",
       {{"at", 0}, {"length", 1e6}, {"camera", 2}, {"contrast", 0.03}},
       "contrasts times this",
       TakeContrast},
      {"dots",
       {{"at", 0}, {"length", 1e6}, {"camera", 2}, {"grey", 40}, {"dots", 3000}},
       "dots that stay where they are in the image, as of an IR projector",
       ProjectDots},
      {"knocked",
       {{"at", 5}, {"length", 1e6}, {"camera", 1}, {"axis", 0}, {"deg", 0.2}},
       "a camera is turned in its mount from then on",
       KnockCamera},
      {"still", {{"share", 1}}, "nothing moves for this share of the time", StandStill},
  };
}

}  // namespace facet
