// SPDX-License-Identifier: BSD-2-Clause
// Facet for other programs, in one header: stereo images and IMU samples in, pose, mesh and planes
// out. Plain data and the standard library only, C++17; neither Eigen nor OpenCV nor any other
// header of Facet is needed, and it does not matter for which processor the including program is
// compiled.
//
//   facet::api::Odometry odometry(facet::api::ReadCalibration("camchain.yaml", "imu.yaml"));
//   odometry.AddImu({t_ns, gyro, accel});                             // in order of time
//   auto state = odometry.AddStereo(t_ns, {left}, {right});           // 8 bit grey images
//   if (state.has_pose) Fly(state.T_WB);
//
// Frames: W is the world (z up, gravity along -z, origin at the first pose), B the body, which is
// the IMU, C the left camera. T_AB maps points from B to A. Quaternions are w x y z, Hamilton. SI
// units; times are nanoseconds of the recording's own clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace facet {
namespace api {

using Vec3 = std::array<double, 3>;

/// What is wrong with a file, an option or a calibration, and what to do about it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Pose {
  Vec3 p{{0, 0, 0}};                      ///< [m]
  std::array<double, 4> q{{1, 0, 0, 0}};  ///< w x y z, unit
};

struct ImuSample {
  std::int64_t t_ns = 0;  ///< IMU clock
  Vec3 gyro{{0, 0, 0}};   ///< angular rate in B [rad/s]
  Vec3 accel{{0, 0, 0}};  ///< specific force in B [m/s^2]
};

/// 8 bit grey, row by row. The pixels are copied, unless `owner` keeps them alive: then they must
/// not be written to while Facet holds a copy of it (for two more frames).
struct Image {
  const std::uint8_t* pixels = nullptr;
  int width = 0, height = 0;
  std::size_t stride_bytes = 0;  ///< from row to row; 0: width
  std::shared_ptr<const void> owner = nullptr;
};

/// An image as drivers and recordings have it, in the words of ROS: sensor_msgs/Image, or, where
/// `encoding` is empty, CompressedImage.
struct EncodedImage {
  /// mono8, mono16, rgb8, bgr8, rgba8, bgra8, yuv422, yuv422_yuy2, bayer_rggb8 and the like; empty:
  /// the bytes are a file (PNG, JPEG, WebP, PGM).
  std::string encoding;
  int width = 0, height = 0;   ///< of a file: not needed
  std::size_t step_bytes = 0;  ///< from row to row; of a file: not needed
  bool is_big_endian = false;
  const std::uint8_t* bytes = nullptr;
  std::size_t num_bytes = 0;
};

/// To the same grey values as `facet run`. Keeps its buffers; not thread-safe.
class ImageDecoder {
 public:
  /// `sample_bits`: how many of 16-bit samples are used, 8 to 16.
  explicit ImageDecoder(int sample_bits = 16);
  ~ImageDecoder();
  ImageDecoder(ImageDecoder&&) noexcept;
  ImageDecoder& operator=(ImageDecoder&&) noexcept;

  /// The pixels have an owner, so they outlive the decoder. Throws Error where the image is damaged
  /// or its encoding is not known.
  Image Decode(const EncodedImage& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Camera with a lens. The coefficients of each model, in their order: k1 k2 p1 p2
/// (radial-tangential), k1 k2 k3 k4 (equidistant), OpenCV's k1 k2 p1 p2 k3 k4 k5 k6 (rational), w
/// (field of view), xi alpha (double sphere), alpha beta (extended unified), k1 k2 p1 p2 xi
/// (unified, Kalibr's "omni").
struct Camera {
  enum class Distortion {
    kNone,
    kRadialTangential,
    kEquidistant,
    kRational,
    kFieldOfView,
    kDoubleSphere,
    kExtendedUnified,
    kUnified
  };
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  Distortion distortion = Distortion::kNone;
  std::array<double, 8> coefficients{{0, 0, 0, 0, 0, 0, 0, 0}};
  Pose T_BC;  ///< camera to body
  /// What this lens does beside its model in images of this size, as a former run estimated it:
  /// what ReadCalibration found, to be handed on as it is [px]. Zeros: not known.
  std::array<double, 10> lens_modes{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
};

struct Calibration {
  Camera left, right;
  double time_offset_s = 0;  ///< t_imu = t_camera + time_offset (Kalibr's timeshift_cam_imu)
  /// Densities as on the IMU's datasheet: rad/s/sqrt(Hz), rad/s^2/sqrt(Hz), m/s^2/sqrt(Hz),
  /// m/s^3/sqrt(Hz).
  double gyro_noise = 1.6968e-4, gyro_walk = 1.9393e-5, accel_noise = 2.0e-3, accel_walk = 3.0e-3;
  /// By what share the gyroscope reads too much on each axis; not zero if a former run estimated
  /// it.
  Vec3 gyro_scale{{0, 0, 0}};
  /// How well a former run knew cameras, mount, time offset and gyroscope: what ReadCalibration
  /// found beside them, a square matrix row by row, to be handed on as it is. Empty: not known.
  std::vector<double> covariance;
};

/// `cameras`: Kalibr's camchain.yaml, or a folder that holds mav0/ (EuRoC). `imu`: Kalibr's
/// imu.yaml or EuRoC's sensor.yaml; may be empty. Throws Error with file and line.
Calibration ReadCalibration(const std::string& cameras, const std::string& imu = "");

/// sensor_msgs/CameraInfo. Matrices are row by row.
struct CameraInfo {
  int width = 0, height = 0;     ///< [px]
  std::string distortion_model;  ///< plumb_bob, rational_polynomial, equidistant, ...
  std::vector<double> D;
  std::array<double, 9> K{{}};   ///< of the raw image
  std::array<double, 9> R{{}};   ///< from the raw to the rectified camera
  std::array<double, 12> P{{}};  ///< of the rectified image; the right one's has the baseline
};

/// What CameraInfo does not tell of a stereo camera.
struct CameraMount {
  Pose T_BC;                   ///< left camera to body, of the raw one where images are rectified
  std::optional<Pose> T_C0C1;  ///< right camera to left; empty: from R and P
  bool are_rectified = false;  ///< the images; then P counts, and K and D do not
  std::string imu_noise;       ///< Kalibr's imu.yaml; empty: the default densities
};

/// Throws Error where something is missing or cannot be.
Calibration CalibrationFromCameraInfo(const CameraInfo& left,
                                      const CameraInfo& right,
                                      const CameraMount& mount);

enum class Status { kInitialising, kOk, kDegraded, kLost };

/// The estimate for one stereo pair, causal: from images and samples up to its stamp.
struct State {
  std::int64_t t_ns = 0;  ///< of the left image
  Status status = Status::kInitialising;
  std::string reason;     ///< why the status is not kOk, or empty
  bool has_pose = false;  ///< false: the numbers below mean nothing
  Pose T_WB;
  /// From W to the map M, where places are recognised (Odometry::Options): a heading and a
  /// position, which change when a place is. T_WB never jumps by that. Otherwise none.
  Pose T_MW;
  bool is_in_map = true;  ///< false: still looked for in the map of earlier runs, T_MW says nothing
  Vec3 v_WB{{0, 0, 0}};   ///< [m/s]
  Vec3 gyro_bias{{0, 0, 0}}, accel_bias{{0, 0, 0}};  ///< [rad/s], [m/s^2]
  Vec3 sigma_p{{0, 0, 0}}, sigma_theta{{0, 0, 0}},
      sigma_v{{0, 0, 0}};  ///< 1-sigma; theta in B [rad]
  /// 15 x 15, row by row: rotation (in B), position and velocity (in W), gyro_bias, accel_bias.
  std::array<double, 225> covariance{};
  bool is_keyframe = false;
  bool was_reset = false;  ///< the state was given up after this frame; the next pose may jump
  std::string warning;     ///< what is, or probably is, wrong with the calibration; else empty
};

/// Triangles in W, counter-clockwise seen from where the surface was seen.
struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> faces;
  std::vector<std::int64_t> plane_ids;               ///< one per face, -1: none
  std::vector<std::array<std::uint8_t, 3>> colours;  ///< red green blue per vertex, or empty
  std::int64_t t_ns = 0;  ///< horizon mesh: stamp of its newest keyframe; else 0
};

/// n . p = d for its points in W.
struct Plane {
  std::int64_t id = -1;
  Vec3 n{{0, 0, 1}};
  double d = 0;
  std::string label;  ///< floor, table, ceiling, wall or other
  double area_m2 = 0, sigma_normal_rad = 0, sigma_d_m = 0;
  std::vector<Vec3> outline;  ///< convex, counter-clockwise seen from where n points
};

/// A piece of the map: the surface in one cube of space.
struct MapPart {
  std::array<int, 3> index{{0, 0, 0}};  ///< which cube; the same for the whole run
  Mesh mesh;                            ///< without faces: there is nothing any more
};

/// How map and planes have changed.
struct SceneChanges {
  std::int64_t t_ns = 0;  ///< stamp of the keyframe
  std::vector<MapPart> parts;
  std::vector<Plane> planes;  ///< all, as Odometry::Planes
  bool is_partial = false;    ///< more of the map has changed than this; ask again
};

/// Deterministic. Not thread-safe: call it from one thread at a time. AddImu and AddStereo never
/// throw for any content of samples or images.
class Odometry {
 public:
  /// Parameters as for `facet run`: a YAML file (may be empty), then key.path=value texts.
  struct Options {
    std::string config_file;
    std::vector<std::string> overrides;
    /// Folder of a map that an earlier run has saved: M is its frame. Recognises places.
    std::string known_map = "";
    bool keeps_map = false;  ///< for SaveMap, which Odometry alone has; recognises places
  };

  /// Throws Error where calibration or options are wrong.
  explicit Odometry(const Calibration& calibration);
  Odometry(const Calibration& calibration, const Options& options);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// What the options held that has no effect any more, or another name now: one line each, for a
  /// log.
  const std::vector<std::string>& Notices() const;

  /// Called within AddStereo as soon as the pose is known, before mesh, planes and map are worked
  /// on.
  void OnPose(std::function<void(const State&)> observer);

  /// Takes the next sample; samples come in order of time.
  void AddImu(const ImuSample& sample);

  /// A stereo pair with the stamp of the left image, after the IMU samples up to it; one sample
  /// beyond it is ideal. An image without pixels is a missing one.
  State AddStereo(std::int64_t t_ns, const Image& left, const Image& right);

  /// The mesh over the last seconds, after the newest keyframe.
  Mesh HorizonMesh() const;
  /// The mesh of the whole run so far; takes a moment.
  Mesh Map() const;
  /// The planes of the run so far: those in the estimator and retired ones, merged ones once.
  /// Planes that turned out not to fit their landmarks, or to be curved, are left out. Takes as
  /// long as Map().
  std::vector<Plane> Planes() const;

  /// Writes the map of places, with that of earlier runs, for `facet run --map` and for
  /// Options::known_map. False, and nothing is written: there are no places yet, or the run was not
  /// found in the map of earlier runs. Throws Error without Options::keeps_map, and where the
  /// folder has another map than the known one or cannot be written.
  bool SaveMap(const std::string& folder) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where a frame F that is fixed to the body is, between and after the stereo pairs.
struct Motion {
  std::int64_t t_ns = 0;  ///< IMU clock
  Pose T_WF;              ///< in the world of LiveOdometry::Options
  Vec3 v_WF{{0, 0, 0}};   ///< of F's origin [m/s]
  Vec3 w_F{{0, 0, 0}};    ///< angular velocity in F, without bias [rad/s]
  Vec3 a_WF{{0, 0, 0}};   ///< of F's origin, without gravity [m/s^2]; that of a turn that becomes
                          ///< faster is left out where F is not the body
  Vec3 gyro_bias{{0, 0, 0}}, accel_bias{{0, 0, 0}};  ///< in B [rad/s], [m/s^2]
  /// 15 x 15, row by row, with what the IMU has added since the newest pair: rotation (in F),
  /// position and velocity (in the world), gyro_bias, accel_bias.
  std::array<double, 225> covariance{};
  Status status = Status::kInitialising;  ///< of the newest pair
  int segment = 0;                        ///< counts losses; poses of two of them may be apart
  double since_pair_s = 0;                ///< age: from the newest pair with a pose to t
  double since_imu_s = 0;                 ///< from the newest sample to t, for which it is held
  /// What smoothing holds back of the estimate: a rotation on the right [rad], then what is to be
  /// added to p and v.
  Vec3 held_back_theta{{0, 0, 0}}, held_back_p{{0, 0, 0}}, held_back_v{{0, 0, 0}};
};

/// The odometry in a running system: IMU, images and a controller each have a thread of their own,
/// and none of them waits for the estimator. Thread-safe; samples come in order of time, and so do
/// pairs. Nothing here throws for any content of samples or images.
class LiveOdometry {
 public:
  enum class World {
    kEnu,  ///< z up; its heading is that of the first pose, not north's
    kNed   ///< the same with x and y exchanged and z down
  };

  struct Options : Odometry::Options {
    Pose T_BF;                  ///< of the frame F that is output, to body; none given: the body
    World world = World::kEnu;  ///< in which it is told where it is
    double smoothing_s = 0;     ///< corrections are spread over this time; 0: at once
    double max_age_s = 1;       ///< no motion is predicted for longer after the newest pair
    int max_waiting_pairs = 2;  ///< one more, and the oldest one is dropped
    bool two_threads = false;   ///< tracking beside the mesh of the pair before
    /// Called on a thread of this object when the mesh of a keyframe is made, and what was asked
    /// for with RequestScene is there. Must be short, and must not throw nor call Finish.
    std::function<void(std::int64_t t_ns)> on_mesh;
  };

  struct Counts {
    std::int64_t pairs = 0, done_pairs = 0, dropped_pairs = 0;
    std::int64_t imu = 0, dropped_imu = 0;
    std::int64_t late_imu_pairs = 0;  ///< worked on without a sample that follows their stamp
    /// From AddStereo until PredictAt knows of the pair: of the newest one, and the largest so far.
    double latency_s = 0, max_latency_s = 0;
    /// The odometry has thrown, or `on_pose` has: nothing is worked on any more, what comes is
    /// dropped, and Finish throws it.
    bool has_failed = false;
  };

  /// `on_pose` is called on a thread of this object as soon as a pose is known; may be empty, and
  /// must not call Finish, nor throw, which ends the odometry (see Counts). Throws Error where
  /// calibration or options are wrong.
  explicit LiveOdometry(const Calibration& calibration,
                        std::function<void(const State&)> on_pose = nullptr);
  LiveOdometry(const Calibration& calibration,
               const Options& options,
               std::function<void(const State&)> on_pose = nullptr);
  ~LiveOdometry();
  LiveOdometry(LiveOdometry&&) noexcept;
  LiveOdometry& operator=(LiveOdometry&&) noexcept;

  /// As Odometry::Notices.
  const std::vector<std::string>& Notices() const;

  /// Returns at once.
  void AddImu(const ImuSample& sample);

  /// Returns at once, with the pixels copied. An image without pixels is a missing one.
  void AddStereo(std::int64_t t_ns, const Image& left, const Image& right);

  /// The motion at a moment of the IMU's clock; empty before the first pose, before the newest pair
  /// and max_age_s after it. Some microseconds; never waits for the estimator.
  std::optional<Motion> PredictAt(std::int64_t t_ns) const;

  /// The mesh over the last seconds, after the newest keyframe.
  Mesh HorizonMesh() const;

  /// The next keyframe tells how map and planes have changed since the last request.
  void RequestScene();

  /// What requests have brought since the last call; empty if nothing. The surface is extracted
  /// here, by the caller's thread. `all_parts`: of the whole map, for whoever begins to listen.
  std::optional<SceneChanges> TakeScene(bool all_parts = false);

  Counts counts() const;

  /// Waits for the pairs that have come, and ends. Throws what `on_pose` threw.
  void Finish();

  /// As Odometry::Map and Odometry::Planes, of the whole run; empty before Finish.
  Mesh Map() const;
  std::vector<Plane> Planes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// OpenCV, with which Facet finds corners, spreads its work over threads of its own, in the whole
/// process. This forbids it, as `facet run` does: images are so small that the threads cost more
/// processor time than they save.
void ForbidOpenCvThreads();

/// Returns the version of the library, for example "0.1.0".
const char* Version();

}  // namespace api
}  // namespace facet
