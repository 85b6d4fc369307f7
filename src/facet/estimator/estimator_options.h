// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the fixed-lag smoother. `facet config` prints those that users turn.
#pragma once

#include "facet/base/options.h"
#include "facet/calibration/lens_modes.h"
#include "facet/geometry/angles.h"

namespace facet {

/// How much noisier the IMU is in use than on its datasheet (vibration, scale errors, timing), and
/// the world that it measures.
struct ImuOptions {
  double gyro_noise_scale = 6.0;   ///< times the calibration's gyro noise density
  double accel_noise_scale = 8.0;  ///< times the calibration's accelerometer noise density
  double gyro_walk_scale = 1.0;    ///< times the gyro bias walk density
  double accel_walk_scale = 1.0;   ///< times the accelerometer bias walk density
  /// A longer hole between samples (and longer than one and a half of their usual steps) is counted
  /// and makes the interval less certain.
  double max_gap_s = 0.02;
  /// Larger densities in a calibration were inflated already, as those that are made with Kalibr
  /// often are: these count instead. More than twice those of the ADIS16448 (1.7e-4 and 2e-3), and
  /// five times those of a RealSense D455 by its Allan plots.
  double max_gyro_noise = 5e-4;   ///< rad/s/sqrt(Hz)
  double max_accel_noise = 5e-3;  ///< m/s^2/sqrt(Hz)
  double gravity_mps2 = 9.81;     ///< magnitude of gravity where the recording was made

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("gyro_noise_scale",
            gyro_noise_scale,
            Range{0.1, 100},
            "times the calibration's gyro noise density",
            Audience::kUsers);
    v.Field("accel_noise_scale",
            accel_noise_scale,
            Range{0.1, 100},
            "times the calibration's accelerometer noise density",
            Audience::kUsers);
    v.Field(
        "gyro_walk_scale", gyro_walk_scale, Range{0.01, 100}, "times the gyro bias walk density");
    v.Field("accel_walk_scale",
            accel_walk_scale,
            Range{0.01, 100},
            "times the accelerometer bias walk density");
    v.Field("max_gap_s",
            max_gap_s,
            Range{0.001, 1},
            "a longer hole between IMU samples is counted as a gap [s]");
    v.Field("max_gyro_noise",
            max_gyro_noise,
            Range{1e-6, 10},
            "a larger gyro noise density in the calibration is taken for this [rad/s/sqrt(Hz)]");
    v.Field("max_accel_noise",
            max_accel_noise,
            Range{1e-5, 100},
            "a larger accelerometer noise density in the calibration is taken for this "
            "[m/s^2/sqrt(Hz)]");
    v.Field("gravity_mps2",
            gravity_mps2,
            Range{1, 30},
            "magnitude of gravity where the recording was made [m/s^2]");
  }
};

/// Which frames stay in the window.
struct WindowOptions {
  int max_full_keyframes = 5;   ///< newest keyframes that keep velocity and biases
  int max_pose_keyframes = 10;  ///< older keyframes that keep only their pose
  int max_start_keyframes =
      16;  ///< nothing is marginalised before the start is over or this many keyframes exist
  double start_s = 2.0;         ///< shortest start: nothing is marginalised or frozen before
  double start_tilt_deg = 0.3;  ///< the start lasts until the 1-sigma tilt is below this
  double covisible_share =
      0.05;  ///< a pose keyframe that shares less of its landmarks with the newest one goes first

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_full_keyframes",
            max_full_keyframes,
            Range{2, 60},
            "newest keyframes that keep velocity and biases",
            Audience::kUsers);
    v.Field("max_pose_keyframes",
            max_pose_keyframes,
            Range{0, 60},
            "older keyframes that keep only their pose",
            Audience::kUsers);
    v.Field("max_start_keyframes",
            max_start_keyframes,
            Range{5, 100},
            "the start ends at the latest with this many keyframes");
    v.Field("start_s", start_s, Range{0, 30}, "nothing is marginalised before this much data [s]");
    v.Field("start_tilt_deg",
            start_tilt_deg,
            Range{0.01, 90},
            "the start lasts until the 1-sigma tilt is below this [deg]");
    v.Field("covisible_share",
            covisible_share,
            Range{0, 1},
            "a pose keyframe sharing less of its landmarks with the newest goes first");
  }
};

/// How the window is solved.
struct SolverOptions {
  int keyframe_iterations = 2;  ///< Levenberg-Marquardt iterations on keyframes, at most
  int frame_iterations = 2;     ///< iterations on the frames in between, at most
  /// Reprojections beyond this many times the usual (median) error count ever less.
  double loss_width = 5.0;
  double outlier_sigma = 5.0;  ///< observations beyond this many sigma are removed after the solve
  double pixel_sigma_scale = 1.0;  ///< times the front end's pixel sigmas
  /// Stop when an iteration lowers the cost (half of chi-square) by less than this: the whole state
  /// then moved by sqrt(2 x) sigma, and the next step is a fraction of it.
  double min_cost_decrease = 3.0;
  double plane_sigma_m = 0.02;  ///< landmarks of a plane across it, each for itself, 1-sigma
  /// The same, what those of one plane have in common: things on a wall are in front of it.
  double plane_common_sigma_m = 0.0025;
  double plane_huber_sigma = 2.0;  ///< distances to planes beyond this many sigma grow linearly

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("keyframe_iterations",
            keyframe_iterations,
            Range{1, 100},
            "iterations on keyframes, at most");
    v.Field("frame_iterations",
            frame_iterations,
            Range{1, 100},
            "iterations on the frames in between, at most");
    v.Field("loss_width",
            loss_width,
            Range{0.1, 1e6},
            "reprojections beyond this many times the usual error count ever less");
    v.Field("outlier_sigma",
            outlier_sigma,
            Range{1, 1000},
            "observations beyond this many sigma are removed");
    v.Field("pixel_sigma_scale",
            pixel_sigma_scale,
            Range{0.05, 20},
            "times the front end's pixel sigmas");
    v.Field("min_cost_decrease",
            min_cost_decrease,
            Range{0, 1e3},
            "stop when an iteration lowers the cost (half of chi-square) by less");
    v.Field("plane_sigma_m",
            plane_sigma_m,
            Range{1e-4, 1},
            "landmarks of a plane across it, each for itself, 1-sigma [m]");
    v.Field("plane_common_sigma_m",
            plane_common_sigma_m,
            Range{0, 1},
            "the same, what those of one plane have in common [m]");
    v.Field("plane_huber_sigma",
            plane_huber_sigma,
            Range{0.01, 100},
            "distances to planes beyond this many sigma grow linearly");
  }
};

/// Relations between planes, and of planes to gravity.
struct RelationOptions {
  double sigma_deg = 0.7;  ///< parallel, orthogonal, coplanar, heading; 1-sigma
  /// Horizontal, vertical: floors and walls are built level and plumb to a few tenths of a degree;
  /// what leans by more than four sigmas is related to gravity no longer.
  double gravity_sigma_deg = 0.3;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("sigma_deg",
            sigma_deg,
            Range{0.01, 45},
            "1-sigma of parallel, orthogonal, coplanar and heading [deg]");
    v.Field("gravity_sigma_deg",
            gravity_sigma_deg,
            Range{0.01, 45},
            "1-sigma of horizontal and vertical [deg]");
  }
};

/// Planes as variables.
struct PlaneOptions {
  int max_planes = 40;  ///< the least certain of more are removed
  RelationOptions relations;

  // Not listed: tests need other values, users do not.

  /// A plane that the prior does not contain and that fewer landmarks lie on is removed; one
  /// landmark is enough if a measurement determines the plane. Fewer than a plane has when it is
  /// confirmed (PlaneTrackingOptions), so that it may lose some.
  int min_landmarks = 5;
  /// An anchor farther from its plane's landmarks follows them: beyond a few metres normal and
  /// offset become correlated, at less the prior is transformed for nothing.
  double anchor_distance_m = 3.0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_planes", max_planes, Range{1, 64}, "the least certain of more are removed");
    v.Group("relations", relations);
  }
};

/// Pipeline SP: landmarks on planes count like the paper's projection factors.
struct ProjectionOptions {
  double sigma_px = 1.8;       ///< noise of their reprojections, 1-sigma per axis
  double tukey_sigma = 4.685;  ///< reprojections beyond this many sigma do not count
  bool convert_back = true;    ///< false, as in the paper: once such, always such

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("sigma_px", sigma_px, Range{0.05, 100}, "noise of their reprojections [px]");
    v.Field("tukey_sigma",
            tukey_sigma,
            Range{0.5, 1000},
            "reprojections beyond this many sigma do not count");
    v.Field("convert_back",
            convert_back,
            Range{},
            "a landmark that leaves its planes is a landmark with a position again; not so in the "
            "paper");
  }
};

/// What is assumed before anything was measured: wide, so that the data decide.
struct StartOptions {
  int min_frames = 7;        ///< stereo frames before the first pose
  double max_wait_s = 0.45;  ///< IMU gravity fit with larger uncertainty is accepted from here on
  double max_tilt_deg =
      2.0;  ///< 1-sigma tilt that is good enough for the first pose before max_wait_s
  int min_landmarks = 12;         ///< stereo landmarks needed for a start
  double sigma_velocity = 3.0;    ///< m/s
  double sigma_gyro_bias = 0.2;   ///< rad/s
  double sigma_accel_bias = 0.2;  ///< m/s^2

  // Not listed: they fix the gauge, and any value far below the errors of a run does. Tests and
  // consistency studies take others.

  double sigma_position = 1e-3;  ///< of the origin [m]
  double sigma_yaw = 1e-3;       ///< of the heading [rad]

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("min_frames", min_frames, Range{3, 60}, "stereo frames before the first pose");
    v.Field("max_wait_s",
            max_wait_s,
            Range{0.1, 10},
            "a larger tilt uncertainty is accepted from here on [s]");
    v.Field("max_tilt_deg",
            max_tilt_deg,
            Range{0.05, 45},
            "tilt uncertainty that is good enough before max_wait_s [deg]");
    v.Field("min_landmarks", min_landmarks, Range{4, 500}, "stereo landmarks needed for a start");
    v.Field(
        "sigma_velocity", sigma_velocity, Range{0.01, 100}, "prior of the first velocity [m/s]");
    v.Field("sigma_gyro_bias", sigma_gyro_bias, Range{1e-4, 10}, "prior of the gyro bias [rad/s]");
    v.Field("sigma_accel_bias",
            sigma_accel_bias,
            Range{1e-3, 10},
            "prior of the accelerometer bias [m/s^2]");
  }
};

/// What is estimated of the calibration, and how well it is known before.
struct CalibrationOptions {
  bool lens = true;   ///< intrinsics of both cameras and the transform between them
  bool mount = true;  ///< the cameras on the IMU
  bool time = true;   ///< clock of the cameras against the IMU's
  bool gyro = true;   ///< scale of the gyroscope's axes
  /// White noise of the corners with which lenses and stereo pair were calibrated; scales all their
  /// errors together.
  double board_noise_px = 0.2;
  /// Root mean square over the image of what lenses do beside their models, 1-sigma.
  double lens_misfit_px = kLensMisfitPrior_px;
  double mount_rotation_deg = 0.1;     ///< 1-sigma of the length
  double mount_translation_m = 0.003;  ///< 1-sigma of the length
  double time_s = 0.001;               ///< 1-sigma
  double gyro_scale_percent = 0.3;     ///< 1-sigma, each axis
  /// 1-sigma, each axis towards each other one. Not estimated: what turns show of it is taken for a
  /// turn of the mount, so that nobody knows the body's axes better.
  double gyro_misalignment_deg = 0.05;

  static CalibrationOptions Held() {
    return {.lens = false, .mount = false, .time = false, .gyro = false};
  }
  /// How well the body's axes are known [rad]; an IMU that is taken as exact has exact ones.
  double AxesSigma() const { return gyro ? gyro_misalignment_deg * kDegree : 0; }
  bool IsHeld() const { return !lens && !mount && !time && !gyro; }

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("lens", lens, Range{}, "estimate lenses and stereo pair", Audience::kUsers);
    v.Field("mount", mount, Range{}, "estimate where the cameras are on the IMU", Audience::kUsers);
    v.Field(
        "time", time, Range{}, "estimate the cameras' clock against the IMU's", Audience::kUsers);
    v.Field("gyro", gyro, "estimate the scale of the gyroscope's axes");
    v.Field("board_noise_px",
            board_noise_px,
            Range{1e-3, 20},
            "how well lenses and stereo pair were calibrated: noise of the board's corners [px]",
            Audience::kUsers);
    v.Field("lens_misfit_px",
            lens_misfit_px,
            Range{1e-6, 20},
            "what lenses do beside their models: root mean square over the image [px]");
    v.Field("mount_rotation_deg",
            mount_rotation_deg,
            Range{1e-4, 10},
            "error of the cameras' direction on the IMU, 1-sigma [deg]");
    v.Field("mount_translation_m",
            mount_translation_m,
            Range{1e-6, 1},
            "error of the cameras' place on the IMU, 1-sigma [m]");
    v.Field("time_s", time_s, Range{1e-7, 0.1}, "error of the cameras' clock, 1-sigma [s]");
    v.Field("gyro_scale_percent",
            gyro_scale_percent,
            Range{1e-4, 10},
            "error of the scale of each axis of the gyroscope, 1-sigma [%]");
    v.Field("gyro_misalignment_deg",
            gyro_misalignment_deg,
            Range{0, 10},
            "error of the direction of each axis of the gyroscope, 1-sigma, not estimated [deg]");
  }
};

struct EstimatorOptions {
  ImuOptions imu;
  WindowOptions window;
  SolverOptions solver;
  StartOptions start;
  PlaneOptions planes;
  ProjectionOptions projection;
  CalibrationOptions calibration;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("imu", imu);
    v.Group("window", window);
    v.Group("solver", solver);
    v.Group("start", start);
    v.Group("planes", planes);
    v.Group("projection", projection);
    v.Group("calibration", calibration);
  }
};

}  // namespace facet
