// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/fault.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <vector>

#include "facet/base/random.h"
#include "facet/faults/image_edits.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {

namespace {

using Values = std::map<std::string, double>;

struct FaultKind {
  std::string name;
  Values defaults;
  std::string meaning;
  void (*plant)(const Values& value, RecordingCopy& recording);
};

// ------------------------------------------------------------------------------- parts of a time

/// From value("at") seconds after the first image on, for value("length") seconds.
struct Span {
  Timestamp begin, end;
  bool Has(Timestamp t) const { return t >= begin && t < end; }
};

Span SpanOf(const Values& value, const RecordingCopy& recording) {
  const Timestamp begin = recording.images[0].front().t + FromSeconds(value.at("at"));
  return {begin, begin + FromSeconds(value.at("length"))};
}

/// The cameras that value("camera") names: 0 left, 1 right, 2 both.
std::vector<std::size_t> CamerasOf(const Values& value) {
  if (value.at("camera") >= 2) return {0, 1};
  return {value.at("camera") < 1 ? std::size_t{0} : std::size_t{1}};
}

template <class Item>
void Erase(std::vector<Item>& items, const Span& span) {
  items.erase(std::remove_if(
                  items.begin(), items.end(), [&](const Item& item) { return span.Has(item.t); }),
              items.end());
}

/// Gives the images of the span an edit.
template <class MakeEdit>
void EditImages(const Values& value, RecordingCopy& recording, const MakeEdit& make_edit) {
  const Span span = SpanOf(value, recording);
  for (const std::size_t camera : CamerasOf(value)) {
    for (RecordedImage& image : recording.images[camera]) {
      if (span.Has(image.t)) image.edits.push_back(make_edit(image, camera));
    }
  }
}

// ---------------------------------------------------------------------------------- the IMU's bad
// day

void GlitchImu(const Values& value, RecordingCopy& recording) {
  const Timestamp t = recording.images[0].front().t + FromSeconds(value.at("at"));
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  int left = static_cast<int>(value.at("samples"));
  for (ImuSample& sample : recording.imu) {
    if (sample.t < t || left-- <= 0) continue;
    if (value.at("gyro") != 0) sample.gyro[axis] = value.at("gyro");
    if (value.at("accel") != 0) sample.accel[axis] = value.at("accel");
  }
}

void CutImu(const Values& value, RecordingCopy& recording) {
  Erase(recording.imu, SpanOf(value, recording));
}

void ClipImu(const Values& value, RecordingCopy& recording) {
  const double w = value.at("gyro"), a = value.at("accel");
  for (ImuSample& sample : recording.imu) {
    if (w > 0) sample.gyro = sample.gyro.cwiseMax(-w).cwiseMin(w);
    if (a > 0) sample.accel = sample.accel.cwiseMax(-a).cwiseMin(a);
  }
}

void FreezeImu(const Values& value, RecordingCopy& recording) {
  const Span span = SpanOf(value, recording);
  std::optional<ImuSample> kept;
  for (ImuSample& sample : recording.imu) {
    if (!span.Has(sample.t)) continue;
    if (!kept) kept = sample;
    sample.gyro = kept->gyro;
    sample.accel = kept->accel;
  }
}

void ShiftImu(const Values& value, RecordingCopy& recording) {
  for (ImuSample& sample : recording.imu)
    sample.t = sample.t - FromSeconds(1e-3 * value.at("ms"));
}

void GyroInDegrees(const Values& /*value*/, RecordingCopy& recording) {
  for (ImuSample& sample : recording.imu)
    sample.gyro /= kDegree;
}

void NegateImu(const Values& value, RecordingCopy& recording) {
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  for (ImuSample& sample : recording.imu) {
    if (value.at("accel_only") == 0) sample.gyro[axis] *= -1;
    if (value.at("gyro_only") == 0) sample.accel[axis] *= -1;
  }
}

// Scale factors, and axes that are not quite orthogonal: what a calibration at one temperature
// leaves.
void ScaleImu(const Values& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  const auto draw = [&] {
    Matrix3d M = Matrix3d::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const double sigma = row == column ? value.at("percent") / 100 : value.at("deg") * kDegree;
        M(row, column) += sigma * rng.Normal();
      }
    }
    return M;
  };
  const Matrix3d of_gyro = draw(), of_accel = draw();
  for (ImuSample& sample : recording.imu) {
    sample.gyro = of_gyro * sample.gyro;
    sample.accel = of_accel * sample.accel;
  }
}

// --------------------------------------------------------------------------------- the cameras'
// bad day

// The image at the beginning stays for the whole span.
void FreezeCamera(const Values& value, RecordingCopy& recording) {
  const Span span = SpanOf(value, recording);
  for (const std::size_t camera : CamerasOf(value)) {
    std::optional<std::filesystem::path> kept;
    for (RecordedImage& image : recording.images[camera]) {
      if (!span.Has(image.t)) continue;
      if (!kept) kept = image.file;
      image.file = *kept;
    }
  }
}

void RepeatImages(const Values& value, RecordingCopy& recording) {
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
void SendOlder(const Values& value, RecordingCopy& recording) {
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
void ExchangeImages(const Values& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  for (std::size_t i = 1; i < recording.images[0].size(); ++i) {
    if (rng.Uniform() >= value.at("share")) continue;
    for (auto& images : recording.images) {
      if (i < images.size()) std::swap(images[i].file, images[i - 1].file);
    }
    ++i;
  }
}

void DropImages(const Values& value, RecordingCopy& recording) {
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

void CutCamera(const Values& value, RecordingCopy& recording) {
  for (const std::size_t camera : CamerasOf(value))
    Erase(recording.images[camera], SpanOf(value, recording));
}

void Pause(const Values& value, RecordingCopy& recording) {
  const Span span = SpanOf(value, recording);
  Erase(recording.imu, span);
  for (auto& images : recording.images)
    Erase(images, span);
}

void Blacken(const Values& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Filled(static_cast<int>(value.at("grey")));
  });
}

void Overexpose(const Values& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Brightened(value.at("gain"));
  });
}

void CoverLens(const Values& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage&, std::size_t) {
    return Covered(value.at("share"));
  });
}

void AddNoise(const Values& value, RecordingCopy& recording) {
  EditImages(value, recording, [&](const RecordedImage& image, std::size_t camera) {
    return Noisy(value.at("sigma"), static_cast<std::uint64_t>(image.t.ns) + camera);
  });
}

void PassBy(const Values& value, RecordingCopy& recording) {
  const Span span = SpanOf(value, recording);
  const StereoRig rig = recording.rig;
  EditImages(value, recording, [&](const RecordedImage& image, std::size_t camera) {
    const double tau = ToSeconds(image.t - span.begin) / value.at("crossing");
    const double phase = 0.5 - 0.5 * std::cos(std::numbers::pi * tau);
    return WithBoard(rig, camera, value.at("share"), value.at("depth"), phase);
  });
}

// ------------------------------------------------------------------------------------ the
// calibration's

void TurnRight(const Values& value, RecordingCopy& recording) {
  Vector3d turn = Vector3d::Zero();
  turn[static_cast<Eigen::Index>(value.at("axis"))] = value.at("deg") * kDegree;
  Quaterniond& q = recording.rig.T_BC[1].q;
  q = (q * ExpSO3(turn)).normalized();
}

void ScaleFocal(const Values& value, RecordingCopy& recording) {
  for (CameraModel& camera : recording.rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.fx *= 1 + value.at("percent") / 100;
    k.fy *= 1 + value.at("percent") / 100;
    camera = CameraModel(k);
  }
}

void ScaleBaseline(const Values& value, RecordingCopy& recording) {
  auto& [left, right] = recording.rig.T_BC;
  right.p = left.p + (1 + value.at("percent") / 100) * (right.p - left.p);
}

void InvertExtrinsics(const Values& /*value*/, RecordingCopy& recording) {
  for (SE3& T_BC : recording.rig.T_BC)
    T_BC = T_BC.Inverse();
}

void SwapCameras(const Values& /*value*/, RecordingCopy& recording) {
  std::swap(recording.images[0], recording.images[1]);
}

const std::vector<FaultKind>& Kinds() {
  static const std::vector<FaultKind> kinds = {
      {"imu_glitch",
       {{"at", 5}, {"samples", 1}, {"axis", 0}, {"gyro", 35}, {"accel", 0}},
       "samples with this value [rad/s, m/s^2; 0: as recorded]",
       GlitchImu},
      {"imu_gap", {{"at", 5}, {"length", 0.3}}, "no IMU", CutImu},
      {"imu_clip", {{"gyro", 0.6}, {"accel", 0}}, "the sensor's range ends there", ClipImu},
      {"imu_frozen", {{"at", 5}, {"length", 0.3}}, "the IMU repeats itself", FreezeImu},
      {"imu_early", {{"ms", 10}}, "stamps of the IMU are early", ShiftImu},
      {"imu_degrees", {}, "the gyroscope measures in deg/s", GyroInDegrees},
      {"imu_negated",
       {{"axis", 0}, {"gyro_only", 0}, {"accel_only", 0}},
       "an axis points the other way",
       NegateImu},
      {"imu_scaled",
       {{"percent", 0.3}, {"deg", 0.05}, {"seed", 1}},
       "scale factors and misalignment of both sensors (1-sigma)",
       ScaleImu},
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
      {"right_turned", {{"axis", 1}, {"deg", 0.2}}, "calibration: the right camera", TurnRight},
      {"focal", {{"percent", 1}}, "calibration: the focal lengths", ScaleFocal},
      {"baseline", {{"percent", 2}}, "calibration: the baseline", ScaleBaseline},
      {"inverted_T_BS", {}, "calibration: extrinsics the wrong way round", InvertExtrinsics},
      {"swapped", {}, "left images are the right ones", SwapCameras},
  };
  return kinds;
}

std::string Parameters(const FaultKind& kind) {
  std::string text;
  for (const auto& [name, value] : kind.defaults) {
    std::ostringstream number;
    number << name << '=' << value;
    text += (text.empty() ? ":" : ",") + number.str();
  }
  return text;
}

Values ParseValues(const std::string& text, const FaultKind& kind) {
  constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
  Values values = kind.defaults;
  std::istringstream stream(text);
  for (std::string entry; std::getline(stream, entry, ',');) {
    const std::size_t equal = entry.find('=');
    const std::string name = entry.substr(0, equal);
    const double value = equal == std::string::npos
                             ? kNotANumber
                             : ParseDouble(entry.substr(equal + 1)).value_or(kNotANumber);
    if (values.count(name) == 0 || !std::isfinite(value)) {
      throw ConfigError("--fault " + kind.name + ": '" + entry +
                        "' is no parameter with a number; known: " + kind.name + Parameters(kind));
    }
    values[name] = value;
  }
  const auto axis = values.find("axis");
  if (axis != values.end() && axis->second != 0 && axis->second != 1 && axis->second != 2)
    throw ConfigError("--fault " + kind.name + ": axis is 0, 1 or 2");
  return values;
}

}  // namespace

void PlantFault(const std::string& fault, RecordingCopy& recording) {
  const std::size_t colon = fault.find(':');
  const std::string name = fault.substr(0, colon);
  const auto kind = std::find_if(
      Kinds().begin(), Kinds().end(), [&](const FaultKind& k) { return k.name == name; });
  if (kind == Kinds().end())
    throw ConfigError("--fault '" + name + "' is not known; known are\n" + ListFaults());
  const std::string rest = colon == std::string::npos ? "" : fault.substr(colon + 1);
  kind->plant(ParseValues(rest, *kind), recording);
}

std::string ListFaults() {
  std::string text;
  for (const FaultKind& kind : Kinds())
    text += "  " + kind.name + Parameters(kind) + "\n      " + kind.meaning + "\n";
  return text;
}

}  // namespace facet
