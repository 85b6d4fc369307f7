// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/robot_node.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "facet/robot/clock_watch.h"
#include "facet/robot/health.h"
#include "facet/robot/motion_covariance.h"
#include "facet/robot/path_keeper.h"
#include "facet/robot/scene_worker.h"
#include "facet/robot/stereo_decoder.h"

namespace facet {
namespace robot {

namespace {

using Clock = std::chrono::steady_clock;
using Lock = std::lock_guard<std::mutex>;

bool IsFinite(const api::ImuSample& sample) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(sample.gyro[i]) || !std::isfinite(sample.accel[i])) return false;
  }
  return true;
}

/// Between two samples, as far as they have been seen [s].
class SamplePeriod {
 public:
  double Add(std::int64_t t_ns) {
    constexpr double kShare = 0.05, kShortest = 1e-4, kLongest = 0.1;
    const double step_s = 1e-9 * static_cast<double>(t_ns - last_ns_);
    if (step_s > kShortest && step_s < kLongest) period_s_ += kShare * (step_s - period_s_);
    last_ns_ = t_ns;
    return period_s_;
  }

 private:
  std::int64_t last_ns_ = 0;
  double period_s_ = 0.005;
};

}  // namespace

class RobotNode::Impl {
 public:
  Impl(const RobotOptions& options, RobotListener& listener)
      : options_(Checked(options)),
        T_BF_(Inverse(options.T_base_imu)),
        listener_(listener),
        decoder_(options.sample_bits),
        pairer_(ToleranceNs()),
        path_(options.max_path, options.path_period_s),
        scene_(listener, options.scene_period_s) {
    for (const std::string& notice : TryOptions(options))
      listener_.OnLog(LogLevel::kWarning, notice);
    calibration_ = options.calibration;
    if (options.known_map.empty()) TellMapTransform(api::Pose());
    if (options.is_started) Start();
  }

  ~Impl() {
    number_ = -1;  // nothing is told any more
    const Lock lock(mutex_);
    session_.reset();
  }

  void AddImu(const api::ImuSample& sample);
  void AddImage(int camera, const ReceivedImage& image);
  void AddCameraInfo(int camera, const api::CameraInfo& info);
  Answer Start();
  Answer Stop();
  Answer Reset();
  void RepeatMap() { scene_.RepeatMap(); }
  Diagnosis Diagnose();

 private:
  std::int64_t ToleranceNs() const {
    return static_cast<std::int64_t>(1e9 * options_.pair_tolerance_s);
  }

  // With mutex_ held.
  void Begin();
  void End();
  void Restart(const std::string& why);
  void NoteProblem(const std::string& text);
  bool IsOfOldClock(std::int64_t t_ns);
  void KeepEarly(const api::ImuSample& sample);
  std::vector<ImagePair> Pair(int camera, const ReceivedImage& image);

  void TellOdometry(const api::LiveOdometry& odometry, std::int64_t t_ns, double gyro_variance);
  void TakeState(int number, const api::State& state);
  void TellPose(int number, const api::State& state);
  void TellMapTransform(const api::Pose& T_map_odom);
  void Feed(api::LiveOdometry& odometry, const ImagePair& pair);
  void CollectCounts(api::LiveOdometry& odometry);

  const RobotOptions options_;
  const api::Pose T_BF_;  // F: the base
  RobotListener& listener_;

  std::mutex image_mutex_;  // one image after the other; taken before mutex_
  StereoDecoder decoder_;

  std::mutex mutex_;
  std::optional<api::Calibration> calibration_;
  std::array<std::optional<api::CameraInfo>, 2> infos_;
  std::shared_ptr<api::LiveOdometry> session_;
  bool is_running_ = false;
  bool may_be_of_old_clock_ = false;  // images that were on their way when the clock went back
  ClockWatch watch_;
  SamplePeriod period_;
  std::deque<api::ImuSample> early_imu_;  // before there is a calibration
  ImagePairer pairer_;
  Health health_;
  HealthCounts ended_;  // of the odometries before this one
  std::int64_t reported_lost_ = 0;
  std::optional<std::int64_t> told_ns_;  // newest sample
  std::optional<Clock::time_point> imu_arrival_;
  std::array<std::optional<Clock::time_point>, 2> image_arrivals_;

  std::atomic<int> number_ = 0;  // of the odometry; what an older one tells is not passed on
  std::mutex path_mutex_;        // also of T_map_odom_
  PathKeeper path_;
  std::optional<api::Pose> T_map_odom_;  // as it was told of this odometry
  SceneWorker scene_;                    // last: its thread tells the listener
};

// ---- beginning and end

RobotNode::Answer RobotNode::Impl::Start() {
  const Lock lock(mutex_);
  if (is_running_) return {false, "it is running already"};
  is_running_ = true;
  if (!calibration_) return {true, "started; it waits for camera_info of both cameras"};
  Begin();
  if (!session_) {
    is_running_ = false;
    return {false, health_.problem};
  }
  return {true, "started"};
}

RobotNode::Answer RobotNode::Impl::Stop() {
  const Lock lock(mutex_);
  if (!is_running_) return {false, "it is stopped already"};
  is_running_ = false;
  End();
  return {true, "stopped"};
}

RobotNode::Answer RobotNode::Impl::Reset() {
  const Lock lock(mutex_);
  if (!is_running_) return {false, "it is stopped; start it"};
  Restart("reset, as was asked for");
  return {true, "reset; it begins anew"};
}

void RobotNode::Impl::Begin() try {
  const int number = ++number_;
  api::LiveOdometry::Options live = LiveOptionsOf(options_);
  live.on_mesh = [this](std::int64_t) { scene_.Notify(); };
  session_ = std::make_shared<api::LiveOdometry>(
      *calibration_, live, [this, number](const api::State& state) { TakeState(number, state); });
  scene_.Follow(session_);
} catch (const std::exception& error) {  // a parameter file that is gone, no thread
  session_.reset();
  NoteProblem(error.what());
}

void RobotNode::Impl::End() {
  ++number_;
  if (session_) CollectCounts(*session_);
  ended_ = health_.counts;
  session_.reset();
  early_imu_.clear();
  scene_.Follow(nullptr);
  watch_.Clear();
  pairer_ = ImagePairer(ToleranceNs());
  health_.status = api::Status::kInitialising;
  health_.reason.clear();
  health_.warning.clear();
  health_.problem.clear();
  told_ns_.reset();
  const Lock path_lock(path_mutex_);
  if (!options_.known_map.empty()) T_map_odom_.reset();
  path_.Clear();
}

void RobotNode::Impl::Restart(const std::string& why) {
  listener_.OnLog(LogLevel::kWarning, why);
  End();
  ++health_.counts.restarts;
  ++ended_.restarts;
  if (calibration_) Begin();
}

void RobotNode::Impl::NoteProblem(const std::string& text) {
  if (text != health_.problem) listener_.OnLog(LogLevel::kError, text);
  health_.problem = text;
}

// ---- what comes

void RobotNode::Impl::AddImu(const api::ImuSample& sample) {
  std::shared_ptr<api::LiveOdometry> odometry;
  double gyro_variance = 0;
  bool is_new = false;
  {
    const Lock lock(mutex_);
    ++health_.counts.imu;
    imu_arrival_ = Clock::now();
    if (!IsFinite(sample)) {
      ++health_.counts.bad_imu;
      NoteProblem("an IMU sample is not finite");
      return;
    }
    if (!is_running_) return;
    if (watch_.HasGoneBack(ClockWatch::kImu, sample.t_ns)) {
      Restart("the stamps of the IMU have gone back: everything begins anew");
      watch_.HasGoneBack(ClockWatch::kImu, sample.t_ns);
      may_be_of_old_clock_ = true;
    }
    odometry = session_;
    if (!odometry) KeepEarly(sample);
    is_new = !told_ns_ || sample.t_ns > *told_ns_;
    if (is_new) told_ns_ = sample.t_ns;
    if (odometry)
      gyro_variance =
          calibration_->gyro_noise * calibration_->gyro_noise / period_.Add(sample.t_ns);
  }
  if (!odometry) return;
  odometry->AddImu(sample);
  // A stamp that comes twice, or late, has been told of.
  if (is_new) TellOdometry(*odometry, sample.t_ns, gyro_variance);
}

/// The start of the estimator profits from the samples before the first pair.
void RobotNode::Impl::KeepEarly(const api::ImuSample& sample) {
  constexpr std::size_t kMost = 2000;  // ten seconds
  early_imu_.push_back(sample);
  if (early_imu_.size() > kMost) early_imu_.pop_front();
}

void RobotNode::Impl::TellOdometry(const api::LiveOdometry& odometry,
                                   std::int64_t t_ns,
                                   double gyro_variance) {
  if (!listener_.WantsOdometry()) return;
  const auto motion = odometry.PredictAt(t_ns);
  if (!motion) return;
  OdometryOutput output;
  output.t_ns = t_ns;
  output.T_odom_base = motion->T_WF;
  output.v_base = InFrame(motion->T_WF, motion->v_WF);
  output.w_base = motion->w_F;
  output.pose_covariance = PoseCovariance(motion->T_WF, api::Pose(), motion->covariance);
  output.twist_covariance = TwistCovariance(*motion, T_BF_, gyro_variance);
  listener_.OnOdometry(output);
}

void RobotNode::Impl::AddImage(int camera, const ReceivedImage& image) {
  const Lock image_lock(image_mutex_);
  std::shared_ptr<api::LiveOdometry> odometry;
  std::vector<ImagePair> pairs;
  {
    const Lock lock(mutex_);
    ++health_.counts.images;
    image_arrivals_[static_cast<std::size_t>(camera)] = Clock::now();
    if (!is_running_) return;
    pairs = Pair(camera, image);
    odometry = session_;
  }
  if (!odometry) return;
  for (const ImagePair& pair : pairs)
    Feed(*odometry, pair);
}

std::vector<ImagePair> RobotNode::Impl::Pair(int camera, const ReceivedImage& image) {
  if (IsOfOldClock(image.t_ns)) return {};
  const auto stream = camera == 0 ? ClockWatch::kLeft : ClockWatch::kRight;
  if (watch_.HasGoneBack(stream, image.t_ns)) {
    Restart("the stamps of the images have gone back: everything begins anew");
    watch_.HasGoneBack(stream, image.t_ns);
  }
  return pairer_.Add(camera, image);
}

/// Images wait longer than IMU samples: after a jump some of before it still come.
bool RobotNode::Impl::IsOfOldClock(std::int64_t t_ns) {
  if (!may_be_of_old_clock_) return false;
  may_be_of_old_clock_ = t_ns - watch_.newest_imu_ns() > ClockWatch::kBackNs;
  return may_be_of_old_clock_;
}

void RobotNode::Impl::Feed(api::LiveOdometry& odometry, const ImagePair& pair) {
  const GreyPair grey = decoder_.Decode(pair, *calibration_);  // it stays once it is there
  if (grey.left.pixels != nullptr) odometry.AddStereo(pair.left.t_ns, grey.left, grey.right);
  const Lock lock(mutex_);
  health_.counts.pairs += grey.left.pixels != nullptr ? 1 : 0;
  health_.counts.bad_images += static_cast<std::int64_t>(grey.problems.size());
  for (const std::string& problem : grey.problems)
    NoteProblem(problem);
}

void RobotNode::Impl::AddCameraInfo(int camera, const api::CameraInfo& info) {
  const Lock lock(mutex_);
  if (calibration_) return;
  infos_[static_cast<std::size_t>(camera)] = info;
  if (!infos_[0] || !infos_[1]) return;
  try {
    calibration_ = api::CalibrationFromCameraInfo(*infos_[0], *infos_[1], options_.mount);
    if (is_running_) Begin();
    for (const api::ImuSample& sample : early_imu_) {
      if (session_) session_->AddImu(sample);
    }
    early_imu_.clear();
    listener_.OnLog(LogLevel::kInfo, "calibration from camera_info");
    health_.problem.clear();
  } catch (const std::exception& error) {
    calibration_.reset();
    NoteProblem(std::string("camera_info: ") + error.what());
  }
}

// ---- what the odometry tells

void RobotNode::Impl::TakeState(int number, const api::State& state) {
  if (number != number_) return;
  {
    const Lock lock(mutex_);
    if (number != number_) return;
    health_.status = state.status;
    health_.reason = state.reason;
    if (!state.warning.empty()) {
      health_.warning = state.warning;
      listener_.OnLog(LogLevel::kWarning, state.warning);
    }
  }
  if (state.was_reset)
    listener_.OnLog(LogLevel::kWarning,
                    "the estimate was given up and begins again: " + state.reason);
  if (state.has_pose) TellPose(number, state);
}

void RobotNode::Impl::TellMapTransform(const api::Pose& T_map_odom) {
  T_map_odom_ = T_map_odom;
  listener_.OnMapTransform(T_map_odom);
}

/// Of one odometry at a time: what ends one clears the path after that.
void RobotNode::Impl::TellPose(int number, const api::State& state) {
  const Lock lock(path_mutex_);
  if (number != number_) return;
  const api::Pose T_WF = Compose(state.T_WB, T_BF_);
  const bool is_told =
      T_map_odom_ && T_map_odom_->p == state.T_MW.p && T_map_odom_->q == state.T_MW.q;
  if (state.is_in_map && !is_told) TellMapTransform(state.T_MW);
  listener_.OnPose({state.t_ns, T_WF, PoseCovariance(state.T_WB, T_BF_, state.covariance)});
  if (path_.Add({state.t_ns, T_WF})) listener_.OnPath(path_.poses());
}

// ---- how it goes

void RobotNode::Impl::CollectCounts(api::LiveOdometry& odometry) {
  const api::LiveOdometry::Counts counts = odometry.counts();
  HealthCounts& total = health_.counts;
  total.done_pairs = ended_.done_pairs + counts.done_pairs;
  total.dropped_pairs = ended_.dropped_pairs + counts.dropped_pairs;
  total.dropped_imu = ended_.dropped_imu + counts.dropped_imu;
  total.late_imu_pairs = ended_.late_imu_pairs + counts.late_imu_pairs;
  total.lone_images = ended_.lone_images + pairer_.counts().lone_left + pairer_.counts().lone_right;
  total.repeated_images = ended_.repeated_images + pairer_.counts().repeated;
  health_.latency_s = counts.latency_s;
  health_.max_latency_s = std::max(health_.max_latency_s, counts.max_latency_s);
  health_.has_failed = counts.has_failed;
}

Diagnosis RobotNode::Impl::Diagnose() {
  const Lock lock(mutex_);
  const auto since = [](const std::optional<Clock::time_point>& t) -> std::optional<double> {
    if (!t) return std::nullopt;
    return std::chrono::duration<double>(Clock::now() - *t).count();
  };
  health_.is_running = is_running_;
  health_.has_odometry = session_ != nullptr;
  health_.has_failed = false;
  if (session_) CollectCounts(*session_);
  health_.silence_s = options_.silence_s;
  health_.since_imu_s = since(imu_arrival_);
  health_.since_left_s = since(image_arrivals_[0]);
  health_.since_right_s = since(image_arrivals_[1]);
  const std::int64_t lost = health_.counts.lost();
  health_.newly_lost = lost - reported_lost_;
  reported_lost_ = lost;
  return Judge(health_);
}

RobotNode::RobotNode(const RobotOptions& options, RobotListener& listener)
    : impl_(std::make_unique<Impl>(options, listener)) {}

RobotNode::~RobotNode() = default;

void RobotNode::AddImu(const api::ImuSample& sample) {
  impl_->AddImu(sample);
}

void RobotNode::AddImage(int camera, const ReceivedImage& image) {
  impl_->AddImage(camera, image);
}

void RobotNode::AddCameraInfo(int camera, const api::CameraInfo& info) {
  impl_->AddCameraInfo(camera, info);
}

RobotNode::Answer RobotNode::Start() {
  return impl_->Start();
}

RobotNode::Answer RobotNode::Stop() {
  return impl_->Stop();
}

RobotNode::Answer RobotNode::Reset() {
  return impl_->Reset();
}

void RobotNode::RepeatMap() {
  impl_->RepeatMap();
}

Diagnosis RobotNode::Diagnose() {
  return impl_->Diagnose();
}

}  // namespace robot
}  // namespace facet
