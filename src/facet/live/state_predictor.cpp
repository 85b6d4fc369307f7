// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/state_predictor.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

// A frame whose state comes later than this after its exposure finds no samples to go on with.
constexpr Duration kLongestLatency{5'000'000'000};
// While nothing comes from the frames; 0.64 s at 200 Hz.
constexpr std::size_t kMaxEntries = 128;

const auto kIsBefore = [](const ImuSample& sample, Timestamp t) { return sample.t < t; };

// The measurement at t between two samples, or the last one where nothing follows it.
ImuSample Between(const ImuSample& a, const ImuSample& b, Timestamp t) {
  ImuSample at = b;
  if (b.t > a.t) {
    const double u = ToSeconds(t - a.t) / ToSeconds(b.t - a.t);
    at.gyro = (1 - u) * a.gyro + u * b.gyro;
    at.accel = (1 - u) * a.accel + u * b.accel;
  }
  at.t = t;
  return at;
}

// What the IMU would have said at t: between the samples around it, or as the nearest one.
ImuSample SampleAt(const std::deque<ImuSample>& samples, Timestamp t) {
  const auto next = std::lower_bound(samples.begin(), samples.end(), t, kIsBefore);
  if (next == samples.end()) return Between(samples.back(), samples.back(), t);
  return Between(next == samples.begin() ? *next : *std::prev(next), *next, t);
}

// a (-) b: theta p v.
Vector<9> Difference(const NavState& a, const NavState& b) {
  Vector<9> d;
  d << LogSO3(b.T_WB.q.conjugate() * a.T_WB.q), a.T_WB.p - b.T_WB.p, a.v_WB - b.v_WB;
  return d;
}

NavState Moved(NavState x, const Vector<9>& offset) {
  x.T_WB.q = (x.T_WB.q * ExpSO3(offset.head<3>())).normalized();
  x.T_WB.p += offset.segment<3>(3);
  x.v_WB += offset.tail<3>();
  return x;
}

PredictedState Describe(const ReckonedState& state,
                        const ImuSample& sample,
                        const StepModel& model,
                        const Vector<9>& offset) {
  const NavState x = Moved(state.x, offset);
  PredictedState out;
  out.t = x.t;
  out.T_WF = x.T_WB;
  out.v_WF = x.v_WB;
  out.w_F = RateOf(sample, x.bias, model.gyro_scale);
  out.a_WF = x.T_WB.q * (sample.accel - x.bias.b_a) + model.parameters.g_W();
  out.bias = x.bias;
  out.covariance = state.covariance;
  if (!offset.isZero(0)) out.held_back = Difference(state.x, x);
  return out;
}

}  // namespace

void ImuTrail::Begin(const CausalState& from,
                     const std::deque<ImuSample>& samples,
                     const StepModel& model) {
  entries_.clear();
  entries_.reserve(kMaxEntries);
  model_ = model;
  ImuSample at{from.x.t, from.x.bias.b_g, from.x.bias.b_a};
  if (!samples.empty()) at = SampleAt(samples, from.x.t);
  entries_.push_back({at, {from.x, from.covariance}});
  Follow(samples);
}

void ImuTrail::Follow(const std::deque<ImuSample>& samples) {
  const auto place = [&](Timestamp t) {
    return std::lower_bound(samples.begin(), samples.end(), t, kIsBefore);
  };
  while (entries_.size() > 1) {
    const auto same = place(entries_.back().sample.t);
    if (same != samples.end() && same->t == entries_.back().sample.t) break;
    entries_.pop_back();
  }
  for (auto it = place(entries_.back().sample.t); it != samples.end(); ++it) {
    if (it->t == entries_.back().sample.t) continue;
    if (entries_.size() == kMaxEntries)
      entries_.erase(entries_.begin(), entries_.begin() + kMaxEntries / 2);
    entries_.push_back({*it, entries_.back().state});
    Advance(std::prev(entries_.end(), 2)->sample, *it, model_, entries_.back().state);
  }
}

const ImuTrail::Entry* ImuTrail::At(Timestamp t) const {
  const Entry* entry = &entries_.back();
  while (entry->sample.t > t)
    --entry;
  return entry;
}

const ImuTrail::Entry* ImuTrail::After(const Entry* entry) const {
  return entry == &entries_.back() ? nullptr : entry + 1;
}

StatePredictor::StatePredictor(const ImuNoise& noise,
                               const ImuOptions& imu,
                               const PredictionOptions& options)
    : parameters_(ParametersInUse(noise, imu)),
      walk_(noise, imu),
      max_gap_(FromSeconds(imu.max_gap_s)),
      options_(options),
      is_body_in_W_(options.frame.T_BF.p.isZero(0) && options.frame.T_BF.q.vec().isZero(0) &&
                    options.frame.world == WorldAxes::kEnu) {}

void StatePredictor::AddImu(const ImuSample& sample) {
  const std::lock_guard lock(mutex_);
  imu_.Add(sample);
  if (imu_.empty()) return;
  imu_.DropBefore(imu_.last_stamp() - kLongestLatency);
  if (!trail_.empty()) trail_.Follow(imu_.samples());
}

// Most of the samples since the frame are integrated without the lock, so that nobody waits for
// them.
void StatePredictor::AddFrame(const CausalState& state,
                              bool has_pose,
                              TrackingStatus status,
                              int segment) {
  const std::lock_guard one_after_the_other(frame_mutex_);
  StepModel model{parameters_, walk_, state.gyro_scale};
  {
    const std::lock_guard lock(mutex_);
    status_ = status;
    if (!has_pose || (!trail_.empty() && state.x.t < frame_t_)) return;
    imu_.TimeIsAt(state.x.t);
    imu_.DropBefore(state.x.t);
    recent_samples_ = imu_.samples();
    model.max_step_s = ToSeconds(std::max(max_gap_, imu_.LongestUsualStep()));
  }
  next_.Begin(state, recent_samples_, model);
  const std::lock_guard lock(mutex_);
  next_.Follow(imu_.samples());
  KeepCorrection(next_, segment);
  segment_ = segment;
  frame_t_ = state.x.t;
  std::swap(trail_, next_);
}

// The share of each correction that is still to come falls evenly to zero. Corrections are small,
// so that their sum is the one after the other.
Vector<9> StatePredictor::OffsetAt(Timestamp t) const {
  Vector<9> offset = Vector<9>::Zero();
  for (const Correction& correction : corrections_) {
    const double left = 1 - ToSeconds(t - correction.t) / options_.smoothing_s;
    offset += std::clamp(left, 0.0, 1.0) * correction.offset;
  }
  return offset;
}

void StatePredictor::KeepCorrection(const ImuTrail& next, int segment) {
  if (segment != segment_) corrections_.clear();
  if (!(options_.smoothing_s > 0) || trail_.empty() || segment != segment_) return;
  const ImuTrail::Entry& now = next.newest();
  const Duration fade = FromSeconds(options_.smoothing_s);
  std::erase_if(corrections_, [&](const Correction& c) { return now.sample.t - c.t >= fade; });
  // The frame may be newer than the newest sample.
  ImuTrail::Entry old = trail_.newest();
  if (old.sample.t > now.sample.t) return;
  Advance(old.sample, Between(old.sample, old.sample, now.sample.t), trail_.model(), old.state);
  corrections_.push_back({now.sample.t, Difference(old.state.x, now.state.x)});
}

std::optional<PredictedState> StatePredictor::PredictAt(Timestamp t) const {
  ImuTrail::Entry at;
  ImuSample end;
  StepModel model{parameters_, walk_};
  Vector<9> offset;
  PredictedState labels;
  {
    const std::lock_guard lock(mutex_);
    if (trail_.empty() || t < trail_.begin()) return std::nullopt;
    labels.since_frame = t - frame_t_;
    if (labels.since_frame > FromSeconds(options_.max_age_s)) return std::nullopt;
    const ImuTrail::Entry* entry = trail_.At(t);
    const ImuTrail::Entry* after = trail_.After(entry);
    at = *entry;
    end = after == nullptr ? at.sample : after->sample;
    model = trail_.model();
    offset = OffsetAt(t);
    labels.since_imu = std::max(Duration{}, t - trail_.newest().sample.t);
    labels.status = status_;
    labels.segment = segment_;
  }
  end = Between(at.sample, end, t);
  Advance(at.sample, end, model, at.state);
  PredictedState out = Describe(at.state, end, model, offset);
  out.status = labels.status;
  out.segment = labels.segment;
  out.since_frame = labels.since_frame;
  out.since_imu = labels.since_imu;
  return is_body_in_W_ ? out : InFrame(out, options_.frame);
}

std::optional<Timestamp> StatePredictor::newest_imu() const {
  const std::lock_guard lock(mutex_);
  if (imu_.empty()) return std::nullopt;
  return imu_.last_stamp();
}

}  // namespace facet
