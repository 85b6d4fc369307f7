// SPDX-License-Identifier: BSD-2-Clause
#include <optional>

#include "align_stereo.h"
#include "arrays.h"
#include "bindings.h"
#include "step_reader.h"
#include <pybind11/stl.h>

#include "facet/facade/plain_calibration.h"
#include "facet/io/errors.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/open_recording.h"
#include "facet/recording/topic_choice.h"

namespace facet::python {
namespace {

/// The pixels as an array that keeps the matrix, and with it the buffer, alive; None if it is
/// empty.
py::object ImageArray(cv::Mat image) {
  if (image.empty()) return py::none();
  auto* kept = new cv::Mat(std::move(image));
  const py::capsule owner(kept, [](void* mat) { delete static_cast<cv::Mat*>(mat); });
  return py::array_t<std::uint8_t>({kept->rows, kept->cols},
                                   {static_cast<py::ssize_t>(kept->step), py::ssize_t{1}},
                                   kept->data,
                                   owner);
}

struct Frame {
  std::int64_t t_ns = 0;
  std::optional<std::int64_t> t_right_ns;
  py::object left, right;
  py::array_t<std::int64_t> imu_t_ns;
  Doubles gyro, accel;
};

void SetImu(const std::vector<ImuSample>& samples, Frame& frame) {
  const auto num = static_cast<py::ssize_t>(samples.size());
  frame.imu_t_ns = py::array_t<std::int64_t>(num);
  frame.gyro = Doubles({num, py::ssize_t{3}});
  frame.accel = Doubles({num, py::ssize_t{3}});
  std::int64_t* t = frame.imu_t_ns.mutable_data();
  double *gyro = frame.gyro.mutable_data(), *accel = frame.accel.mutable_data();
  for (const ImuSample& sample : samples) {
    *t++ = sample.t.ns;
    gyro = std::copy_n(sample.gyro.data(), 3, gyro);
    accel = std::copy_n(sample.accel.data(), 3, accel);
  }
}

/// A part of a recording as `facet run` reads it.
class RecordingReader {
 public:
  RecordingReader(const std::string& path,
                  const RecordingOptions& options,
                  const RunRange& range,
                  bool check_calibration)
      : recording_(OpenRecording(path, options)), range_(range) {
    const Calibration& calibration = *recording_->calibration();
    StereoRig rig = calibration.rig;
    if (check_calibration) rig = Align();
    calibration_ = api::PlainCalibration(rig, calibration.imu_noise);
  }

  void Restart() {
    recording_->Rewind();
    steps_.emplace(*recording_, range_);
    decoder_.emplace(recording_->calibration()->rig);
    is_at_start_ = true;
  }

  /// Throws StopIteration at the end of the part, InputError where the recording is damaged. A
  /// frame whose left image is unusable is passed over, and its IMU samples go to the next one.
  Frame Next() {
    if (!steps_) Restart();
    RunStep step;
    DecodedFrame decoded;
    std::vector<ImuSample> imu;
    bool has_frame = false;
    {
      const py::gil_scoped_release release;
      while (!has_frame && Read(step)) {
        imu.insert(imu.end(), step.imu.begin(), step.imu.end());
        decoder_->Decode(step.frame, decoded);
        NoteProblems(decoded);
        has_frame = decoded.left_problem.empty();
      }
    }
    if (!has_frame) {
      const std::string damage = steps_->damage();
      if (!damage.empty()) throw InputError(damage);
      throw py::stop_iteration();
    }
    Frame frame;
    frame.t_ns = step.frame.t.ns;
    if (step.frame.HasRight()) frame.t_right_ns = step.frame.t_right.ns;
    frame.left = ImageArray(std::move(decoded.left));
    frame.right = ImageArray(std::move(decoded.right));
    SetImu(imu, frame);
    return frame;
  }

  const api::Calibration& calibration() const { return calibration_; }
  const std::string& name() const { return recording_->name(); }

  std::vector<std::string> Warnings() const {
    std::vector<std::string> warnings = recording_->Warnings();
    warnings.insert(warnings.end(), problems_.begin(), problems_.end());
    return warnings;
  }

 private:
  StereoRig Align() {
    AlignedRig aligned = AlignStereo(*recording_, range_.start_s);
    if (!aligned.refusal.empty()) {
      throw InputError(recording_->calibration()->source + ": the calibration cannot be right: " +
                       aligned.refusal + " (check_calibration=False goes on with it)");
    }
    if (!aligned.warning.empty()) problems_.push_back(aligned.warning);
    return aligned.rig;
  }

  bool Read(RunStep& step) {
    if (!std::exchange(is_at_start_, false)) return steps_->Next(step);
    if (!steps_->FindFirst(step)) steps_->ThrowNoPair();
    return true;
  }

  void NoteProblems(const DecodedFrame& decoded) {
    for (const std::string& problem : {decoded.left_problem, decoded.right_problem}) {
      if (!problem.empty()) problems_.push_back(problem);
    }
  }

  std::unique_ptr<Recording> recording_;
  RunRange range_;
  api::Calibration calibration_;
  std::optional<StepReader> steps_;
  std::optional<FrameDecoder> decoder_;
  bool is_at_start_ = true;
  std::vector<std::string> problems_;
};

std::unique_ptr<RecordingReader> OpenReader(const std::string& path,
                                            const std::string& calibration,
                                            const std::string& imu_calibration,
                                            const std::vector<std::string>& topics,
                                            double start_s,
                                            double duration_s,
                                            double imu_history_s,
                                            bool check_calibration) {
  RecordingOptions options;
  options.calibration = {calibration, imu_calibration};
  options.topics = ParseTopics(topics);
  RunRange range;
  range.start_s = start_s;
  range.duration_s = duration_s;
  range.imu_history_s = imu_history_s;
  return std::make_unique<RecordingReader>(path, options, range, check_calibration);
}

}  // namespace

void BindRecording(py::module_& module) {
  py::class_<Frame>(module, "Frame", "A stereo pair and the IMU samples since the one before it.")
      .def_readonly("t_ns", &Frame::t_ns, "Stamp of the left image.")
      .def_readonly("t_right_ns", &Frame::t_right_ns, "Stamp of the right image, or None.")
      .def_readonly("left", &Frame::left, "uint8, (height, width).")
      .def_readonly("right", &Frame::right, "The same, or None where it is missing or unusable.")
      .def_readonly("imu_t_ns", &Frame::imu_t_ns, "Stamps of N samples: IMU clock, int64.")
      .def_readonly("gyro", &Frame::gyro, "N x 3, angular rate in B [rad/s].")
      .def_readonly("accel", &Frame::accel, "N x 3, specific force in B [m/s^2].")
      .def("__repr__", [](const Frame& frame) {
        return "<facet.Frame " + std::to_string(frame.t_ns) + " ns, " +
               std::to_string(frame.imu_t_ns.size()) + " IMU samples>";
      });
  py::class_<RecordingReader>(module, "Recording")
      .def(py::init(&OpenReader),
           py::arg("path"),
           py::arg("calibration"),
           py::arg("imu_calibration"),
           py::arg("topics"),
           py::arg("start_s"),
           py::arg("duration_s"),
           py::arg("imu_history_s"),
           py::arg("check_calibration"),
           py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("name", &RecordingReader::name)
      .def_property_readonly("calibration",
                             &RecordingReader::calibration,
                             py::return_value_policy::copy,
                             "The one that facet.run begins with: the recording's, or with the "
                             "right camera turned as the first pairs say (see `warnings`).")
      .def_property_readonly("warnings",
                             &RecordingReader::Warnings,
                             "What is odd about it but does not keep it from being used; more may "
                             "be found while it is read.")
      .def(
          "__iter__",
          [](const py::object& self) {
            self.cast<RecordingReader&>().Restart();
            return self;
          },
          "From the beginning.")
      .def("__next__", &RecordingReader::Next);
}

}  // namespace facet::python
