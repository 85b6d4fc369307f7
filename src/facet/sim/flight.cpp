// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/flight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kRate = 200;  // poses per second

/// How a kind of motion looks.
struct Style {
  const char* name;
  FlightKind kind;
  double speed;       // m/s along the route
  double rounding_s;  // corners are rounded over this time
  double sway_m;      // slow wandering beside the route, amplitude
  double sway_hz;     //   and its highest frequency
  double turn_rad;    // looking around besides the direction of motion
  double pitch_rad;   // looking down
  double shake_rad;   // fast rotations, amplitude
  double shake_hz;    //   and their highest frequency
  double jitter_rad;  // rotations of the attitude control, 2 to 8 Hz
  double tilt;        // share of the thrust direction that the body follows: 1 a drone
  double bounce_m;    // steps of a walker
};

constexpr std::array<Style, 6> kStyles = {{
    {"gentle", FlightKind::kGentle, 0.45, 0.8, 0.06, 0.3, 0.35, 0.12, 0.012, 2.5, 0.0009, 1, 0},
    {"fast", FlightKind::kFast, 1.1, 0.55, 0.08, 0.5, 0.4, 0.12, 0.02, 3, 0.0012, 1, 0},
    {"aggressive", FlightKind::kAggressive, 1.9, 0.4, 0.1, 0.7, 0.4, 0.12, 0.03, 3.5, 0.0015, 1, 0},
    {"hover", FlightKind::kHover, 0.0, 1.0, 0.08, 0.25, 0.1, 0.12, 0.012, 2.5, 0.0008, 1, 0},
    {"hand-held", FlightKind::kHandHeld, 0.25, 0.6, 0.09, 0.8, 0.35, 0.3, 0.06, 1.6, 0.0003, 0, 0},
    {"walk", FlightKind::kWalk, 1.0, 0.5, 0.04, 0.5, 0.2, 0.15, 0.03, 2, 0.0003, 0, 0.02},
}};

const Style& StyleOf(FlightKind kind) {
  return *std::find_if(
      kStyles.begin(), kStyles.end(), [&](const Style& s) { return s.kind == kind; });
}

/// A few sines of random frequency and phase; amplitude about 1.
class Wander {
 public:
  Wander(double max_hz, Rng& rng) {
    for (Sine& s : sines_)
      s = {kTwoPi * max_hz * rng.Uniform(0.25, 1), rng.Uniform(0, kTwoPi)};
  }
  double At(double t) const {
    double sum = 0;
    for (const Sine& s : sines_)
      sum += std::sin(s.frequency * t + s.phase);
    return sum / std::sqrt(1.5);
  }

 private:
  struct Sine {
    double frequency = 0, phase = 0;
  };
  std::array<Sine, 3> sines_;
};

/// A polyline by arc length, walked in laps if it returns to one of its points, otherwise back and
/// forth.
class Route {
 public:
  explicit Route(std::span<const Vector3d> points) : points_(points.begin(), points.end()) {
    for (std::size_t i = 1; i < points_.size(); ++i)
      ends_.push_back((ends_.empty() ? 0 : ends_.back()) + (points_[i] - points_[i - 1]).norm());
    const auto same = std::find(points_.begin(), points_.end() - 1, points_.back());
    const auto first_of_lap = static_cast<std::size_t>(same - points_.begin());
    const double lap_begin = first_of_lap > 0 ? ends_[first_of_lap - 1] : 0;
    lap_ = ends_.back() - lap_begin;
  }
  struct Place {
    Vector3d p_W, direction_W;
  };
  Place At(double s) const {
    const double length = ends_.back();
    const bool is_loop = lap_ > 0;
    double at = s;
    if (s > length)
      at = is_loop ? length - lap_ + std::fmod(s - length, lap_) : std::fmod(s, 2 * length);
    const bool is_back = at > length;
    if (is_back) at = 2 * length - at;
    const auto end = std::min(std::lower_bound(ends_.begin(), ends_.end(), at), ends_.end() - 1);
    const auto i = static_cast<std::size_t>(end - ends_.begin());
    const double begin = i > 0 ? ends_[i - 1] : 0;
    const double u = (at - begin) / std::max(1e-9, *end - begin);
    const Vector3d step = points_[i + 1] - points_[i];
    return {points_[i] + u * step, step.normalized() * (is_back ? -1.0 : 1.0)};
  }

 private:
  std::vector<Vector3d> points_;
  std::vector<double> ends_;  // arc length at points_[i + 1]
  double lap_ = 0;            // length of the part that is walked again and again; 0: none
};

/// Gaussian running mean; the ends are continued with the end values.
template <class T>
std::vector<T> Smooth(const std::vector<T>& values, double sigma_s) {
  const int reach = static_cast<int>(std::ceil(4 * sigma_s * kRate));
  std::vector<double> weights;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double x = k / (sigma_s * kRate);
    weights.push_back(std::exp(-0.5 * x * x));
    sum += weights.back();
  }
  const int n = static_cast<int>(values.size());
  std::vector<T> result(values.size());
  for (int i = 0; i < n; ++i) {
    T mean = values[static_cast<std::size_t>(i)] * 0.0;
    for (int k = -reach; k <= reach; ++k) {
      const auto j = static_cast<std::size_t>(std::clamp(i + k, 0, n - 1));
      mean += weights[static_cast<std::size_t>(k + reach)] / sum * values[j];
    }
    result[static_cast<std::size_t>(i)] = mean;
  }
  return result;
}

/// Arc length over time: starts from rest, then varies around the style's speed.
std::vector<double> ArcLengths(const Style& style, int count, const Wander& pace, double begin_s) {
  std::vector<double> lengths;
  double s = 0.3;
  for (int i = 0; i < count; ++i) {
    lengths.push_back(s);
    const double t = i / kRate - begin_s;
    const double ramp = t <= 0 ? 0 : 1 - std::exp(-t * t / 2);
    s += style.speed * ramp * (1 + 0.3 * pace.At(t)) / kRate;
  }
  return lengths;
}

struct Path {
  std::vector<Vector3d> p_W;
  std::vector<double> heading;
};

Path FollowRoute(const Style& style,
                 const Route& route,
                 const std::vector<double>& lengths,
                 Rng& rng) {
  const std::array<Wander, 3> sway = {
      Wander(style.sway_hz, rng), Wander(style.sway_hz, rng), Wander(style.sway_hz, rng)};
  const Wander look(0.25, rng);
  const double step_hz = rng.Uniform(1.7, 2.0);
  Path path;
  double heading = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const Route::Place place = route.At(lengths[i]);
    path.p_W.push_back(place.p_W);
    const double angle = std::atan2(place.direction_W.y(), place.direction_W.x());
    heading += std::remainder(angle - heading, kTwoPi);
    path.heading.push_back(heading);
  }
  path.p_W = Smooth(path.p_W, style.rounding_s);
  path.heading = Smooth(path.heading, 1.5 * style.rounding_s);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const double t = static_cast<double>(i) / kRate;
    for (int k = 0; k < 3; ++k)
      path.p_W[i](k) += style.sway_m * sway[static_cast<std::size_t>(k)].At(t);
    path.p_W[i].z() += style.bounce_m * std::sin(kTwoPi * step_hz * t);
    path.heading[i] += style.turn_rad * look.At(t);
  }
  return path;
}

/// Second derivative by central differences, smoothed: only the tilt of the body follows it.
std::vector<Vector3d> Accelerations(const std::vector<Vector3d>& p) {
  std::vector<Vector3d> a(p.size(), Vector3d::Zero());
  for (std::size_t i = 1; i + 1 < p.size(); ++i)
    a[i] = (p[i + 1] - 2 * p[i] + p[i - 1]) * (kRate * kRate);
  return Smooth(a, 0.1);
}

/// Body axes for a heading and an up direction: x up, z forward.
Quaterniond Attitude(double heading, const Vector3d& up_W) {
  const Vector3d forward(std::cos(heading), std::sin(heading), 0);
  Matrix3d R_WB;
  R_WB.col(0) = up_W.normalized();
  R_WB.col(1) = forward.cross(R_WB.col(0)).normalized();
  R_WB.col(2) = R_WB.col(0).cross(R_WB.col(1));
  R_WB.col(1) = R_WB.col(2).cross(R_WB.col(0));
  return Quaterniond(R_WB).normalized();
}

}  // namespace

std::optional<FlightKind> FlightKindFromText(const std::string& name) {
  for (const Style& style : kStyles) {
    if (name == style.name) return style.kind;
  }
  return std::nullopt;
}

std::string FlightNames() {
  std::string names;
  for (const Style& style : kStyles)
    names += (names.empty() ? "" : ", ") + std::string(style.name);
  return names;
}

bool HasRotors(FlightKind kind) {
  return StyleOf(kind).tilt > 0;
}

std::vector<NavState> MakeFlightPoses(FlightKind kind,
                                      std::span<const Vector3d> route_W,
                                      const FlightOptions& options) {
  FACET_CHECK(route_W.size() >= 2) << "a route needs two points";
  const Style& style = StyleOf(kind);
  Rng rng(options.seed);
  const int count =
      static_cast<int>(std::ceil((options.duration_s + 2 * options.lead_s) * kRate)) + 1;
  const Wander pace(0.1, rng), roll(style.shake_hz, rng), pitch(style.shake_hz, rng),
      yaw(style.shake_hz, rng);
  constexpr double kJitterHz = 8;
  const Wander jitter_x(kJitterHz, rng), jitter_y(kJitterHz, rng), jitter_z(kJitterHz, rng);
  const std::vector<double> lengths = ArcLengths(style, count, pace, options.lead_s + 0.5);
  const Path path = FollowRoute(style, Route(route_W), lengths, rng);
  const std::vector<Vector3d> a_W = Accelerations(path.p_W);

  std::vector<NavState> states;
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double t = i / kRate;
    NavState state;
    state.t = options.start + FromSeconds(t - options.lead_s);
    state.T_WB.p = path.p_W[k];
    const Vector3d up_W = style.tilt * a_W[k] - GravityInWorld();
    const Vector3d shake(style.shake_rad * yaw.At(t),  // about the body's x axis, which is up
                         style.shake_rad * pitch.At(t) - style.pitch_rad - options.look_down,
                         style.shake_rad * roll.At(t));
    const Vector3d jitter(0.4 * jitter_x.At(t), jitter_y.At(t), jitter_z.At(t));
    state.T_WB.q =
        (Attitude(path.heading[k], up_W) * ExpSO3(shake + style.jitter_rad * jitter)).normalized();
    states.push_back(state);
  }
  return states;
}

}  // namespace facet
