// SPDX-License-Identifier: BSD-2-Clause
#include "facet/facet.h"

#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/core.hpp>

#include "facet/calibration/calibration_vector.h"
#include "facet/facade/plain_calibration.h"
#include "facet/frontend/patch_kernels.h"
#include "facet/io/calibration_file.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/io/saved_map_file.h"
#include "facet/live/live_vio.h"
#include "facet/mesh/map_follower.h"
#include "facet/pipeline/vio_pipeline.h"

namespace facet::api {

namespace {

// Enumerators are converted by number.
constexpr int Number(auto enumerator) {
  return static_cast<int>(enumerator);
}
static_assert(Number(Status::kInitialising) == Number(TrackingStatus::kInitialising));
static_assert(Number(Status::kOk) == Number(TrackingStatus::kOk));
static_assert(Number(Status::kDegraded) == Number(TrackingStatus::kDegraded));
static_assert(Number(Status::kLost) == Number(TrackingStatus::kLost));
static_assert(Number(Camera::Distortion::kNone) == Number(DistortionModel::kNone));
static_assert(Number(Camera::Distortion::kRadialTangential) ==
              Number(DistortionModel::kRadialTangential));
static_assert(Number(Camera::Distortion::kEquidistant) == Number(DistortionModel::kEquidistant));
static_assert(Number(Camera::Distortion::kUnified) == Number(DistortionModel::kUnified));

Vec3 Plain(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Pose Plain(const SE3& T) {
  return {Plain(T.p), {T.q.w(), T.q.x(), T.q.y(), T.q.z()}};
}

Camera Plain(const CameraModel& camera, const SE3& T_BC) {
  const CameraIntrinsics& k = camera.intrinsics();
  Camera plain;
  plain.width = k.width;
  plain.height = k.height;
  plain.fx = k.fx;
  plain.fy = k.fy;
  plain.cx = k.cx;
  plain.cy = k.cy;
  plain.distortion = static_cast<Camera::Distortion>(k.distortion);
  plain.coefficients = k.coefficients;
  plain.T_BC = Plain(T_BC);
  return plain;
}

CameraModel Internal(const Camera& plain, const char* name) {
  CameraIntrinsics k;
  k.width = plain.width;
  k.height = plain.height;
  k.fx = plain.fx;
  k.fy = plain.fy;
  k.cx = plain.cx;
  k.cy = plain.cy;
  k.distortion = static_cast<DistortionModel>(plain.distortion);
  k.coefficients = plain.coefficients;
  const std::string problem = CameraModel::WhatIsWrong(k);
  if (!problem.empty()) throw Error(std::string(name) + " camera: " + problem);
  return CameraModel(k);
}

Vector3d Internal(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

std::shared_ptr<const MatrixXd> CovarianceOf(const std::vector<double>& rows) {
  if (rows.empty()) return nullptr;
  if (rows.size() != kNumCalibration * kNumCalibration)
    throw Error("covariance: neither empty nor as ReadCalibration gives it");
  const CalibrationMatrix matrix = Eigen::Map<const CalibrationMatrix>(rows.data());
  const std::string problem = WhatIsWrong(matrix);
  if (!problem.empty()) throw Error("covariance: " + problem);
  return std::make_shared<const MatrixXd>(matrix);
}

LensModeVector ModesOf(const Camera& camera) {
  const LensModeVector modes(camera.lens_modes.data());
  if (!modes.allFinite() || modes.cwiseAbs().maxCoeff() > 20)
    throw Error("lens_modes must be pixels, up to 20");
  return modes;
}

StereoRig RigOf(const Calibration& calibration) {
  StereoRig rig;
  rig.cameras = {Internal(calibration.left, "left"), Internal(calibration.right, "right")};
  rig.lens_modes = {ModesOf(calibration.left), ModesOf(calibration.right)};
  rig.T_BC = {Internal(calibration.left.T_BC, "T_BC"), Internal(calibration.right.T_BC, "T_BC")};
  if (!(std::abs(calibration.time_offset_s) <= 1))
    throw Error("time_offset_s must be seconds, from -1 to 1");
  rig.time_offset = FromSeconds(calibration.time_offset_s);
  rig.gyro_scale = Internal(calibration.gyro_scale);
  if (!rig.gyro_scale.allFinite() || rig.gyro_scale.cwiseAbs().maxCoeff() > 0.5)
    throw Error("gyro_scale must be a share, from -0.5 to 0.5");
  rig.covariance = CovarianceOf(calibration.covariance);
  for (const SE3& T_BC : rig.T_BC) {
    if (!(T_BC.p.norm() <= 10)) throw Error("T_BC: the position must be metres, up to 10");
  }
  if (!(rig.baseline_m() > 1e-3)) throw Error("the cameras are at the same place");
  return rig;
}

facet::ImuNoise NoiseOf(const Calibration& calibration) {
  facet::ImuNoise noise;
  noise.gyro_noise = calibration.gyro_noise;
  noise.gyro_walk = calibration.gyro_walk;
  noise.accel_noise = calibration.accel_noise;
  noise.accel_walk = calibration.accel_walk;
  for (const double density :
       {noise.gyro_noise, noise.gyro_walk, noise.accel_noise, noise.accel_walk}) {
    if (!(density > 0 && density < 1e5))
      throw Error("the IMU's noise densities must be above 0 and below 1e5");
  }
  return noise;
}

VioOptions OptionsOf(const Odometry::Options& plain, std::vector<std::string>& notices) {
  VioOptions options;
  const std::vector<ConfigField> fields = ListFields(options);
  try {
    if (!plain.config_file.empty())
      notices = ApplyConfig(ReadConfigFile(plain.config_file), fields, RetiredOptions());
    for (std::string& notice : ApplyOverrides(plain.overrides, fields, RetiredOptions()))
      notices.push_back(std::move(notice));
    if (!plain.known_map.empty())
      options.known_map = std::make_shared<SavedMap>(ReadSavedMap(plain.known_map));
  } catch (const std::runtime_error& error) {
    throw Error(error.what());
  }
  options.keeps_map = plain.keeps_map;
  options.loops.enabled = options.loops.enabled || options.keeps_map || options.known_map;
  if (const std::string& simd = options.frontend.klt.simd; FindPatchKernels(simd) == nullptr) {
    throw Error("frontend.klt.simd = '" + simd +
                "': this machine has no such instructions; allowed: auto | scalar");
  }
  return options;
}

// The odometry keeps references to the pixels of the newest images, so it gets them with an owner.
class OwnedImage {
 public:
  explicit OwnedImage(const Image& image) : owner_(image.owner) {
    if (image.pixels == nullptr || image.width <= 0 || image.height <= 0) return;
    const std::size_t stride =
        image.stride_bytes == 0 ? static_cast<std::size_t>(image.width) : image.stride_bytes;
    if (stride < static_cast<std::size_t>(image.width))
      throw Error("an image's stride_bytes is less than its width");
    const cv::Mat view(image.height,
                       image.width,
                       CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels),  // never written to
                       stride);
    pixels_ = owner_ ? view : view.clone();
  }
  const cv::Mat& pixels() const { return pixels_; }

 private:
  std::shared_ptr<const void> owner_;
  cv::Mat pixels_;
};

std::array<double, 225> Plain(const Matrix<15, 15>& covariance) {
  std::array<double, 225> rows;
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 15; ++column)
      rows[static_cast<std::size_t>(15 * row + column)] = covariance(row, column);
  }
  return rows;
}

State Plain(const VioOutput& output) {
  State state;
  state.t_ns = output.t.ns;
  state.status = static_cast<Status>(output.status);
  state.reason = output.reason;
  state.has_pose = output.has_pose;
  state.T_WB = Plain(output.state.T_WB);
  state.T_MW = Plain(output.T_MW);
  state.is_in_map = output.is_in_map;
  state.v_WB = Plain(output.state.v_WB);
  state.gyro_bias = Plain(output.state.bias.b_g);
  state.accel_bias = Plain(output.state.bias.b_a);
  state.sigma_p = Plain(output.sigma_p);
  state.sigma_theta = Plain(output.sigma_theta);
  state.sigma_v = Plain(output.sigma_v);
  state.covariance = Plain(output.covariance);
  state.is_keyframe = output.is_keyframe;
  state.was_reset = output.was_reset;
  state.warning = output.refusal.empty() ? output.warning : output.refusal;
  return state;
}

facet::ImuSample Internal(const ImuSample& sample) {
  return {{sample.t_ns},
          {sample.gyro[0], sample.gyro[1], sample.gyro[2]},
          {sample.accel[0], sample.accel[1], sample.accel[2]}};
}

Motion Plain(const PredictedState& state) {
  Motion motion;
  motion.t_ns = state.t.ns;
  motion.T_WF = Plain(state.T_WF);
  motion.v_WF = Plain(state.v_WF);
  motion.w_F = Plain(state.w_F);
  motion.a_WF = Plain(state.a_WF);
  motion.gyro_bias = Plain(state.bias.b_g);
  motion.accel_bias = Plain(state.bias.b_a);
  motion.covariance = Plain(state.covariance);
  motion.status = static_cast<Status>(state.status);
  motion.segment = state.segment;
  motion.since_pair_s = ToSeconds(state.since_frame);
  motion.since_imu_s = ToSeconds(state.since_imu);
  motion.held_back_theta = Plain(Vector3d(state.held_back.head<3>()));
  motion.held_back_p = Plain(Vector3d(state.held_back.segment<3>(3)));
  motion.held_back_v = Plain(Vector3d(state.held_back.tail<3>()));
  return motion;
}

Mesh Plain(const TriangleMesh& mesh) {
  Mesh plain;
  plain.vertices.reserve(mesh.vertices.size());
  for (const Vector3d& vertex : mesh.vertices)
    plain.vertices.push_back(Plain(vertex));
  plain.faces = mesh.faces;
  plain.plane_ids.assign(mesh.plane_ids.begin(), mesh.plane_ids.end());
  plain.colours = mesh.colours;
  return plain;
}

Plane Plain(const PlaneRecord& record) {
  Plane plain;
  plain.id = record.id.value;
  plain.n = Plain(record.plane_W.n);
  plain.d = record.plane_W.d;
  plain.label = ToString(record.label);
  plain.area_m2 = record.area_m2;
  plain.sigma_normal_rad = record.sigma_normal_rad;
  plain.sigma_d_m = record.sigma_d_m;
  for (const Vector3d& corner : record.outline_W)
    plain.outline.push_back(Plain(corner));
  return plain;
}

}  // namespace

struct Odometry::Impl {
  Impl(const Calibration& calibration, const Options& options)
      : pipeline(RigOf(calibration), NoiseOf(calibration), OptionsOf(options, notices)),
        known_map(options.known_map),
        keeps_map(options.keeps_map) {}

  std::vector<std::string> notices;
  VioPipeline pipeline;
  std::string known_map;
  bool keeps_map;
  std::shared_ptr<const MeshSnapshot> mesh;
  PoseObserver observer;
  std::vector<std::pair<OwnedImage, OwnedImage>> images;  // of the newest frames
};

SE3 Internal(const Pose& pose, const std::string& name) {
  const auto& [w, x, y, z] = pose.q;
  const Quaterniond q(w, x, y, z);
  if (!(std::abs(q.norm() - 1) < 1e-3))
    throw Error(name + ": the quaternion is not of unit length");
  const Vector3d p(pose.p[0], pose.p[1], pose.p[2]);
  if (!p.allFinite()) throw Error(name + ": the position is not finite");
  // One that is of unit length but for rounding stays as it is, bit by bit.
  constexpr double kRounding = 1e-15;
  return {std::abs(q.squaredNorm() - 1) < kRounding ? q : q.normalized(), p};
}

Calibration PlainCalibration(const StereoRig& rig, const facet::ImuNoise& noise) {
  Calibration plain;
  plain.left = Plain(rig.cameras[0], rig.T_BC[0]);
  plain.right = Plain(rig.cameras[1], rig.T_BC[1]);
  std::copy_n(rig.lens_modes[0].data(), kNumLensModes, plain.left.lens_modes.data());
  std::copy_n(rig.lens_modes[1].data(), kNumLensModes, plain.right.lens_modes.data());
  plain.time_offset_s = ToSeconds(rig.time_offset);
  plain.gyro_noise = noise.gyro_noise;
  plain.gyro_walk = noise.gyro_walk;
  plain.accel_noise = noise.accel_noise;
  plain.accel_walk = noise.accel_walk;
  plain.gyro_scale = Plain(rig.gyro_scale);
  if (rig.covariance)
    plain.covariance.assign(rig.covariance->data(),
                            rig.covariance->data() + rig.covariance->size());
  return plain;
}

Calibration ReadCalibration(const std::string& cameras, const std::string& imu) try {
  const bool is_folder = std::filesystem::is_directory(cameras);
  const std::filesystem::path folder = cameras;
  const facet::Calibration read =
      is_folder
          ? FindCalibration(std::filesystem::exists(folder / "mav0") ? folder / "mav0" : folder,
                            {{}, imu})
          : ReadKalibrCalibration(cameras, imu);
  return PlainCalibration(read.rig, read.imu_noise);
} catch (const InputError& error) {
  throw Error(error.what());
}

Odometry::Odometry(const Calibration& calibration) : Odometry(calibration, Options()) {}

Odometry::Odometry(const Calibration& calibration, const Options& options)
    : impl_(std::make_unique<Impl>(calibration, options)) {}

Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

const std::vector<std::string>& Odometry::Notices() const {
  return impl_->notices;
}

void Odometry::OnPose(std::function<void(const State&)> observer) {
  impl_->observer = nullptr;
  if (!observer) return;
  impl_->observer = [observer = std::move(observer)](const VioOutput& output) {
    observer(Plain(output));
  };
}

void Odometry::AddImu(const ImuSample& sample) {
  impl_->pipeline.AddImu(Internal(sample));
}

State Odometry::AddStereo(std::int64_t t_ns, const Image& left, const Image& right) {
  constexpr std::size_t kNumReferenced = 3;  // StereoFrame: two further frames
  auto& images = impl_->images;
  if (images.size() == kNumReferenced) images.erase(images.begin());
  const auto& [l, r] = images.emplace_back(OwnedImage(left), OwnedImage(right));
  const VioOutput output =
      impl_->pipeline.AddStereo({{t_ns}, l.pixels(), r.pixels()}, impl_->observer);
  if (output.mesh) impl_->mesh = output.mesh;
  return Plain(output);
}

namespace {

/// Null before the first keyframe.
Mesh HorizonOf(const MeshSnapshot* snapshot) {
  if (snapshot == nullptr) return {};
  Mesh mesh = Plain(snapshot->mesh);
  mesh.t_ns = snapshot->t.ns;
  return mesh;
}

Mesh MapOf(const RunResult& result) {
  return result.map ? Plain(*result.map) : Mesh();
}

std::vector<Plane> PlanesOf(const RunResult& result) {
  std::vector<Plane> planes;
  if (!result.planes) return planes;
  for (const PlaneRecord& record : *result.planes)
    planes.push_back(Plain(record));
  return planes;
}

}  // namespace

Mesh Odometry::HorizonMesh() const {
  return HorizonOf(impl_->mesh.get());
}

Mesh Odometry::Map() const {
  return MapOf(impl_->pipeline.Result());
}

std::vector<Plane> Odometry::Planes() const {
  return PlanesOf(impl_->pipeline.Result());
}

bool Odometry::SaveMap(const std::string& folder) const try {
  if (!impl_->keeps_map) throw Error("SaveMap needs Options::keeps_map");
  std::error_code other;
  const std::filesystem::path file = std::filesystem::path(folder) / kSavedMapName;
  if (std::filesystem::exists(file, other) &&
      !std::filesystem::equivalent(folder, impl_->known_map, other))
    throw Error(folder + ": has a map already, which is not Options::known_map");
  const std::optional<LoopResult> loops = impl_->pipeline.Result().loops;
  const bool was_found = loops && (!loops->has_known_map || loops->localised);
  if (!was_found || !loops->map || loops->map->places.empty()) return false;
  WriteSavedMap(folder, *loops->map);
  return true;
} catch (const OutputError& error) {
  throw Error(error.what());
}

struct LiveOdometry::Impl {
  Impl(const Calibration& calibration,
       const Options& options,
       std::function<void(const State&)> on_pose)
      : vio_options(OptionsOf(options, notices)),
        on_mesh(options.on_mesh),
        map(vio_options.mesh.map),
        vio(
            RigOf(calibration),
            NoiseOf(calibration),
            vio_options,
            Internal(options),
            [on_pose = std::move(on_pose)](const VioOutput& output) {
              if (on_pose) on_pose(Plain(output));
            },
            [this](const VioOutput& output) {
              if (output.mesh) TakeMesh(output);
            }) {}

  void TakeMesh(const VioOutput& output) {
    {
      const std::lock_guard lock(mesh_mutex);
      mesh = output.mesh;
      if (output.scene_update) updates.emplace_back(output.t.ns, output.scene_update);
    }
    if (on_mesh) on_mesh(output.t.ns);
  }

  static LiveOptions Internal(const Options& plain) {
    LiveOptions options;
    if (!(plain.smoothing_s >= 0 && plain.smoothing_s <= 10))
      throw Error("smoothing_s must be seconds, from 0 to 10");
    if (!(plain.max_age_s > 0 && plain.max_age_s <= 60))
      throw Error("max_age_s must be seconds, above 0, up to 60");
    if (plain.max_waiting_pairs < 1) throw Error("max_waiting_pairs must be 1 or more");
    options.prediction.smoothing_s = plain.smoothing_s;
    options.prediction.max_age_s = plain.max_age_s;
    options.prediction.frame.T_BF = api::Internal(plain.T_BF, "T_BF");
    options.prediction.frame.world = plain.world == World::kNed ? WorldAxes::kNed : WorldAxes::kEnu;
    options.max_waiting_frames = static_cast<std::size_t>(plain.max_waiting_pairs);
    options.two_threads = plain.two_threads;
    return options;
  }

  std::vector<std::string> notices;
  const VioOptions vio_options;
  const std::function<void(std::int64_t)> on_mesh;
  mutable std::mutex mesh_mutex;
  std::shared_ptr<const MeshSnapshot> mesh;
  std::vector<std::pair<std::int64_t, std::shared_ptr<const SceneUpdate>>> updates;
  std::mutex map_mutex;
  MapFollower map;
  mutable std::mutex finish_mutex;
  std::optional<RunResult> result;  // of Finish
  LiveVio vio;                      // last: its threads use the others
};

LiveOdometry::LiveOdometry(const Calibration& calibration,
                           std::function<void(const State&)> on_pose)
    : LiveOdometry(calibration, Options(), std::move(on_pose)) {}

LiveOdometry::LiveOdometry(const Calibration& calibration,
                           const Options& options,
                           std::function<void(const State&)> on_pose)
    : impl_(std::make_unique<Impl>(calibration, options, std::move(on_pose))) {}

LiveOdometry::~LiveOdometry() = default;
LiveOdometry::LiveOdometry(LiveOdometry&&) noexcept = default;
LiveOdometry& LiveOdometry::operator=(LiveOdometry&&) noexcept = default;

const std::vector<std::string>& LiveOdometry::Notices() const {
  return impl_->notices;
}

void LiveOdometry::AddImu(const ImuSample& sample) {
  impl_->vio.AddImu(Internal(sample));
}

void LiveOdometry::AddStereo(std::int64_t t_ns, const Image& left, const Image& right) {
  const auto copy = [](const Image& image) {
    return OwnedImage({image.pixels, image.width, image.height, image.stride_bytes, nullptr});
  };
  impl_->vio.AddStereo({{t_ns}, copy(left).pixels(), copy(right).pixels()});
}

std::optional<Motion> LiveOdometry::PredictAt(std::int64_t t_ns) const {
  const std::optional<PredictedState> state = impl_->vio.PredictAt({t_ns});
  if (!state) return std::nullopt;
  return Plain(*state);
}

Mesh LiveOdometry::HorizonMesh() const {
  std::shared_ptr<const MeshSnapshot> mesh;
  {
    const std::lock_guard lock(impl_->mesh_mutex);
    mesh = impl_->mesh;
  }
  return HorizonOf(mesh.get());
}

void LiveOdometry::RequestScene() {
  impl_->vio.RequestSceneUpdate();
}

std::optional<SceneChanges> LiveOdometry::TakeScene(bool all_parts) {
  decltype(impl_->updates) updates;
  {
    const std::lock_guard lock(impl_->mesh_mutex);
    updates.swap(impl_->updates);
  }
  if (updates.empty()) return std::nullopt;
  const std::lock_guard lock(impl_->map_mutex);
  for (const auto& [t_ns, update] : updates)
    impl_->map.Take(update->map_blocks);
  if (all_parts) impl_->map.MarkAll();
  SceneChanges changes;
  changes.t_ns = updates.back().first;
  changes.is_partial = updates.back().second->is_partial;
  for (const PlaneRecord& record : updates.back().second->planes)
    changes.planes.push_back(Plain(record));
  while (const auto part = impl_->map.TakePart()) {
    const CubeIndex& at = part->index;
    changes.parts.push_back({{at.x, at.y, at.z}, Plain(part->mesh)});
  }
  return changes;
}

LiveOdometry::Counts LiveOdometry::counts() const {
  const LiveCounts counts = impl_->vio.counts();
  Counts plain;
  plain.pairs = counts.frames;
  plain.done_pairs = counts.done_frames;
  plain.dropped_pairs = counts.dropped_frames;
  plain.imu = counts.imu;
  plain.dropped_imu = counts.dropped_imu;
  plain.late_imu_pairs = counts.late_imu_frames;
  plain.latency_s = counts.latency_s;
  plain.max_latency_s = counts.max_latency_s;
  plain.has_failed = counts.has_failed;
  return plain;
}

void LiveOdometry::Finish() {
  const std::lock_guard lock(impl_->finish_mutex);
  if (!impl_->result) impl_->result = impl_->vio.Finish();
}

Mesh LiveOdometry::Map() const {
  const std::lock_guard lock(impl_->finish_mutex);
  return impl_->result ? MapOf(*impl_->result) : Mesh();
}

std::vector<Plane> LiveOdometry::Planes() const {
  const std::lock_guard lock(impl_->finish_mutex);
  return impl_->result ? PlanesOf(*impl_->result) : std::vector<Plane>();
}

void ForbidOpenCvThreads() {
  cv::setNumThreads(1);
}

const char* Version() {
  return FACET_VERSION;
}

}  // namespace facet::api
