// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/simulator.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <span>

#include "facet/calibration/lens_modes.h"
#include "facet/io/calibration_file.h"
#include "facet/io/errors.h"
#include "facet/io/png_writer.h"
#include "facet/render/calibration_draw.h"
#include "facet/render/clearance.h"
#include "facet/render/exposure.h"
#include "facet/render/image_renderer.h"
#include "facet/render/image_sensor.h"
#include "facet/render/parallel_for.h"
#include "facet/render/scene_source.h"
#include "facet/render/sequence_writer.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

struct Sensors {
  StereoRig rig;
  ImuNoise noise;
};

/// What the file of an IMU without noise says of it: no density may be zero, and between its
/// samples the motion has to be guessed.
ImuNoise WithoutNoise(ImuNoise noise) {
  constexpr double kShare = 0.05;
  for (double* density :
       {&noise.gyro_noise, &noise.accel_noise, &noise.gyro_walk, &noise.accel_walk}) {
    *density *= kShare;
  }
  return noise;
}

Sensors ChooseSensors(const SimulationRequest& request) {
  Sensors sensors{EurocRig(), {}};
  if (!request.calibration.empty()) {
    const Calibration read = FindCalibration({}, {request.calibration, {}});
    sensors = {read.rig, read.imu_noise};
    sensors.rig.time_offset = {};  // the files of a sequence cannot say it
  }
  const bool is_clean = request.imu.empty() && !request.options.imu.add_noise;
  if (is_clean) sensors.noise = WithoutNoise(sensors.noise);
  sensors.noise.rate_hz = request.options.imu.rate_hz;
  return sensors;
}

std::vector<SE3> PosesAt(const SplineTrajectory& trajectory, const std::vector<Timestamp>& stamps) {
  std::vector<SE3> poses;
  for (const Timestamp t : stamps)
    poses.push_back(trajectory.At(t).state.T_WB);
  return poses;
}

/// The truth at the samples of a real IMU: exact pose and velocity, recorded biases.
std::vector<NavState> TruthAtSamples(const Motion& motion) {
  std::vector<NavState> states;
  std::size_t next = 0;
  for (const ImuSample& sample : motion.real_imu) {
    while (next + 1 < motion.recorded.size() && motion.recorded[next + 1].t <= sample.t)
      ++next;
    NavState state = motion.trajectory.At(sample.t).state;
    state.bias = motion.recorded[next].bias;
    states.push_back(state);
  }
  return states;
}

void WriteInertialData(const SimulationRequest& request,
                       const Motion& motion,
                       const ImuNoise& noise,
                       std::uint64_t seed,
                       const std::optional<ImuErrors>& errors,
                       const std::filesystem::path& folder) {
  if (!motion.real_imu.empty()) {
    std::vector<ImuSample> samples = motion.real_imu;
    if (errors) AddImuErrors(*errors, samples);
    WriteImu(folder, samples);
    WriteStates(folder, TruthAtSamples(motion));
    return;
  }
  SensedImu imu = SenseImu(motion.trajectory,
                           motion.imu_begin,
                           motion.imu_end,
                           noise,
                           request.options.imu,
                           motion.vibration,
                           seed);
  if (errors) AddImuErrors(*errors, imu.samples);
  WriteImu(folder, imu.samples);
  WriteStates(folder, imu.truth);
}

/// How far the image moves during the exposure, at the middle and the corners, for points 2 m away.
double MotionInPixels(const CameraModel& camera, const SE3& T_WC_begin, const SE3& T_WC_end) {
  constexpr double kDepth_m = 2;
  const SE3 T_end_begin = T_WC_end.Inverse() * T_WC_begin;
  double largest = 0;
  for (const double x : {0.05, 0.5, 0.95}) {
    for (const double y : {0.05, 0.5, 0.95}) {
      const Vector2d px(x * camera.width(), y * camera.height());
      const auto ray = camera.Unproject(px);
      if (!ray) continue;
      const auto moved = camera.Project(T_end_begin * Vector3d(kDepth_m * *ray));
      if (moved) largest = std::max(largest, (*moved - px).norm());
    }
  }
  return largest;
}

/// Poses of a camera during the exposure, one for each ray of a pixel.
std::vector<SE3> SamplePoses(const SplineTrajectory& trajectory,
                             const CameraModel& camera,
                             const SE3& T_BC,
                             Timestamp middle,
                             double exposure_s,
                             const ImageOptions& options) {
  const auto T_WC = [&](double share) {
    const Timestamp t = middle + FromSeconds(exposure_s * (share - 0.5));
    return trajectory.At(t).state.T_WB * T_BC;
  };
  const int needed = static_cast<int>(std::ceil(MotionInPixels(camera, T_WC(0), T_WC(1))));
  const int count = std::clamp(
      needed, options.rays_per_pixel, std::max(options.rays_per_pixel, options.max_rays_per_pixel));
  std::vector<SE3> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(T_WC((i + 0.5) / count));
  return poses;
}

/// Writes one image of a camera into each folder, each with its own noise. `index` is unique among
/// the images of a sequence.
void WriteNoisyImages(const cv::Mat1f& radiance,
                      const CameraRays& camera,
                      double gain,
                      const ImageSensorOptions& options,
                      const Seeds& seeds,
                      std::uint64_t index,
                      std::span<const std::filesystem::path> files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Rng rng(seeds.WithNoise(static_cast<int>(i)).noise + index);
    WritePng(files[i], ExposeSensor(radiance, camera, gain, options, rng));
  }
}

/// What both lenses do beside their models; empty if they follow them.
std::optional<std::array<LensMisfit, 2>> DrawMisfits(const SimulationRequest& request,
                                                     const StereoRig& rig) {
  if (!request.lens_misfit) return std::nullopt;
  const auto& [left, right] = rig.cameras;
  Rng rng(*request.lens_misfit);
  const std::uint64_t left_seed = rng.Next(), right_seed = rng.Next();
  const double rms_px = request.options.image.lens_misfit_px;
  return std::array{LensMisfit::Draw(left, rms_px, left_seed),
                    LensMisfit::Draw(right, rms_px, right_seed)};
}

std::array<CameraRays, 2> MakeRays(const SimulationRequest& request, const StereoRig& rig) {
  const auto& [left, right] = rig.cameras;
  const auto misfits = DrawMisfits(request, rig);
  if (!misfits) return {CameraRays(left), CameraRays(right)};
  return {CameraRays(left, misfits->front()), CameraRays(right, misfits->back())};
}

/// The rig with what its lenses do beside their models.
StereoRig ExactRig(const SimulationRequest& request, StereoRig rig) {
  const auto misfits = DrawMisfits(request, rig);
  for (std::size_t c = 0; misfits && c < 2; ++c) {
    const LensModes modes(rig.cameras[c]);
    rig.lens_modes[c] = modes.Nearest([&](const Vector2d& px) { return (*misfits)[c].At(px); });
  }
  return rig;
}

/// Renders and writes all stereo pairs; false if the observer stopped it.
bool WriteImages(const SimulationRequest& request,
                 const Motion& motion,
                 const StereoRig& rig,
                 const ImageRenderer& renderer,
                 const Seeds& seeds,
                 std::span<const std::filesystem::path> folders,
                 const SimulationObserver& observer) {
  const SimulatorOptions& options = request.options;
  const std::array<CameraRays, 2> cameras = MakeRays(request, rig);
  std::vector<SE3> T_WC0 = PosesAt(motion.trajectory, motion.frames);
  for (SE3& T : T_WC0)
    T = T * rig.T_BC[0];
  const std::vector<Exposure> exposures = PlanExposures(
      renderer, cameras[0], T_WC0, options.image, seeds.exposure, request.num_threads);

  std::atomic<bool> is_stopped{false};
  std::mutex observer_mutex;
  int num_done = 0;
  const int num_pairs = static_cast<int>(motion.frames.size());
  ParallelFor(num_pairs, request.num_threads, [&](int i) {
    if (is_stopped) return;
    const auto k = static_cast<std::size_t>(i);
    for (std::size_t c = 0; c < 2; ++c) {
      const std::vector<SE3> poses = SamplePoses(motion.trajectory,
                                                 rig.cameras[c],
                                                 rig.T_BC[c],
                                                 motion.frames[k],
                                                 exposures[k].seconds,
                                                 options.image);
      const cv::Mat1f radiance = renderer.Render(cameras[c], poses, options.image.blur_px);
      std::vector<std::filesystem::path> files;
      for (const auto& folder : folders)
        files.push_back(ImageFile(folder, static_cast<int>(c), motion.frames[k]));
      WriteNoisyImages(
          radiance, cameras[c], exposures[k].gain[c], options.sensor, seeds, 2 * k + c, files);
    }
    const std::lock_guard lock(observer_mutex);
    if (!observer(++num_done, num_pairs)) is_stopped = true;
  });
  for (const auto& folder : folders)
    WriteImageLists(folder, motion.frames);
  return !is_stopped;
}

std::set<int> UsedMaterials(const SceneMesh& mesh) {
  std::set<int> used;
  for (const ScenePart& part : mesh.parts)
    used.insert(part.material);
  return used;
}

void DescribePath(const Motion& motion, SimulationReport& report) {
  report.num_pairs = static_cast<int>(motion.frames.size());
  report.duration_s = ToSeconds(motion.frames.back() - motion.frames.front());
  report.smoothing = motion.smoothing;
  report.found_bias = motion.found_bias;
  std::optional<Vector3d> previous;
  for (const Timestamp t : motion.frames) {
    const NavState state = motion.trajectory.At(t).state;
    report.max_speed = std::max(report.max_speed, state.v_WB.norm());
    if (previous) report.path_m += (state.T_WB.p - *previous).norm();
    previous = state.T_WB.p;
  }
}

}  // namespace

SimulationReport Simulate(const SimulationRequest& request,
                          std::span<const std::filesystem::path> folders,
                          const SimulationObserver& observer) {
  const Seeds seeds(request.seed);
  const Sensors sensors = ChooseSensors(request);
  const Motion motion = MakeMotion(request, seeds);
  MaterialLibrary materials(seeds.textures, request.textures);
  SceneModel scene = MakeScene(request, motion, seeds, materials);

  const RayScene rays(scene.mesh);
  const Clearance clearance = CheckClearance(scene.mesh,
                                             rays,
                                             motion.trajectory,
                                             motion.imu_begin,
                                             motion.imu_end,
                                             request.options.min_clearance_m);
  if (!clearance.problem.empty()) {
    throw InputError("--scene " + request.scene + ", --trajectory " + request.trajectory + ": " +
                     clearance.problem + "; take another scene, flight or --seed");
  }
  SimulationReport report;
  DescribePath(motion, report);
  report.min_clearance_m = clearance.min_distance_m;
  report.num_triangles = scene.mesh.triangles.size();
  // Between the stages before the first image, each of which takes seconds.
  const auto is_wanted = [&] { return observer(0, report.num_pairs); };
  if (!is_wanted()) return report;
  materials.Paint(UsedMaterials(scene.mesh), request.num_threads);
  BakeLight(rays, scene.lighting, seeds.light, request.num_threads, scene.mesh);
  const ImageRenderer renderer(
      scene.mesh, materials, rays, scene.lighting, request.options.image.highlights);

  if (!is_wanted()) return report;
  const SurfaceTruth truth = FindSeenSurfaces(scene.mesh,
                                              rays,
                                              sensors.rig,
                                              PosesAt(motion.trajectory, motion.frames),
                                              1 / request.options.image.rate_hz,
                                              request.options.truth,
                                              seeds.truth,
                                              request.num_threads);
  const CalibrationDraw draw{
      request.drawn_calibration, request.drawn_parts, request.options.calibration};
  const StereoRig measured = WrittenCalibration(sensors.rig, draw);
  const std::optional<ImuErrors> imu_errors = UnknownImuErrors(draw);
  StereoRig exact = ExactRig(request, sensors.rig);
  if (imu_errors) exact.gyro_scale = GyroScaleWith(*imu_errors, exact.gyro_scale);
  for (std::size_t i = 0; i < folders.size(); ++i) {
    WriteCalibration(folders[i], measured, exact, sensors.noise, request.options.image.rate_hz);
    const std::uint64_t imu_seed = seeds.WithNoise(static_cast<int>(i)).imu;
    WriteInertialData(request, motion, sensors.noise, imu_seed, imu_errors, folders[i]);
    if (imu_errors) WriteImuErrors(folders[i], *imu_errors);
    WriteSurfaces(folders[i], scene.mesh, truth);
  }

  report.num_points = truth.points_W.size();
  report.num_planes = static_cast<std::size_t>(
      std::count_if(scene.mesh.parts.begin(), scene.mesh.parts.end(), [](const ScenePart& part) {
        return part.is_planar;
      }));
  if (!is_wanted()) return report;
  const auto begin = std::chrono::steady_clock::now();
  report.is_complete =
      WriteImages(request, motion, sensors.rig, renderer, seeds, folders, observer);
  report.render_wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace facet
