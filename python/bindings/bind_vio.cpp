// SPDX-License-Identifier: BSD-2-Clause
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

#include "arrays.h"
#include "bindings.h"
#include "image_keeper.h"
#include "poses.h"
#include <pybind11/stl.h>

#include "facet/facet.h"

namespace facet::python {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<const char*, 4> kStatusNames = {"initialising", "ok", "degraded", "lost"};

/// facet::api::Odometry with the interpreter's lock released while it works, and one call at a
/// time.
class Vio {
 public:
  Vio(const api::Calibration& calibration, const api::Odometry::Options& options)
      : odometry_(calibration, options), left_(calibration.left), right_(calibration.right) {}

  const std::vector<std::string>& Notices() const { return odometry_.Notices(); }

  void OnPose(const py::object& observer) {
    const bool is_wanted = !observer.is_none();
    Alone([&] {
      {
        const py::gil_scoped_acquire acquire;
        observer_ = observer;
      }
      if (!is_wanted) return odometry_.OnPose(nullptr);
      odometry_.OnPose([this](const api::State& state) { Tell(state); });
    });
  }

  void AddImu(const py::object& t_ns, const py::object& gyro, const py::object& accel) {
    const auto stamps = Stamps(t_ns, "t_ns");
    if (stamps.ndim() > 1) throw py::value_error("t_ns: one stamp, or a row of them");
    const py::ssize_t num = stamps.size();
    const Doubles gyros = Rows(gyro, num, 3, "gyro"), accels = Rows(accel, num, 3, "accel");
    const std::int64_t* t = stamps.data();
    const double *w = gyros.data(), *a = accels.data();
    Alone([&] {
      for (py::ssize_t i = 0; i < num; ++i, w += 3, a += 3)
        odometry_.AddImu({t[i], {{w[0], w[1], w[2]}}, {{a[0], a[1], a[2]}}});
    });
  }

  api::State AddStereo(const py::object& stamp,
                       const py::object& left,
                       const py::object& right,
                       bool copy) {
    const auto t_ns = Stamps(stamp, "t_ns");
    if (t_ns.ndim() > 0) throw py::value_error("t_ns: one stamp");
    const api::Image l = images_.Keep(left, left_.width, left_.height, copy, "left");
    const api::Image r = images_.Keep(right, right_.width, right_.height, copy, "right");
    api::State state;
    std::exception_ptr problem;
    Alone([&] {
      state = odometry_.AddStereo(*t_ns.data(), l, r);
      problem = std::exchange(problem_, nullptr);
    });
    images_.Drop();
    if (problem) std::rethrow_exception(problem);
    return state;
  }

  std::unique_ptr<api::Mesh> HorizonMesh() {
    auto mesh = std::make_unique<api::Mesh>();
    Alone([&] { *mesh = odometry_.HorizonMesh(); });
    return mesh;
  }

  std::unique_ptr<api::Mesh> Map() {
    auto mesh = std::make_unique<api::Mesh>();
    Alone([&] { *mesh = odometry_.Map(); });
    return mesh;
  }

  std::vector<api::Plane> Planes() {
    std::vector<api::Plane> planes;
    Alone([&] { planes = odometry_.Planes(); });
    return planes;
  }

  double seconds_inside() const { return seconds_inside_.load(); }

 private:
  /// Also where what is done throws.
  class Busy {
   public:
    explicit Busy(std::atomic<std::thread::id>& thread) : thread_(thread) {
      thread_ = std::this_thread::get_id();
    }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    ~Busy() { thread_ = std::thread::id(); }

   private:
    std::atomic<std::thread::id>& thread_;
  };

  /// Calls `work` without the interpreter's lock, and alone.
  template <class Work>
  void Alone(const Work& work) {
    if (busy_thread_.load() == std::this_thread::get_id())
      throw api::Error("on_pose may not call the Vio that calls it; keep what you need for later");
    const py::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    const Busy busy(busy_thread_);
    const Clock::time_point start = Clock::now();
    work();
    seconds_inside_ = seconds_inside_ + std::chrono::duration<double>(Clock::now() - start).count();
  }

  /// What the observer raises is kept until the interpreter can raise it.
  void Tell(const api::State& state) {
    const py::gil_scoped_acquire acquire;
    try {
      observer_(state);
    } catch (...) {
      if (!problem_) problem_ = std::current_exception();
    }
  }

  ImageKeeper images_;  // outlives the odometry, which refers to them
  api::Odometry odometry_;
  api::Camera left_, right_;
  py::object observer_ = py::none();
  std::exception_ptr problem_;
  std::mutex mutex_;
  std::atomic<std::thread::id> busy_thread_ = std::thread::id();
  std::atomic<double> seconds_inside_ = 0;
};

std::unique_ptr<Vio> MakeVio(const api::Calibration& calibration,
                             const std::string& config,
                             const std::vector<std::string>& overrides) {
  return std::make_unique<Vio>(calibration, api::Odometry::Options{config, overrides});
}

template <class Member>
auto ArrayOf(Member member) {
  return [member](const api::State& state) { return ToArray(state.*member); };
}

void BindState(py::module_& module) {
  using api::State;
  py::class_<State>(
      module,
      "State",
      "The estimate for one stereo pair, causal: from images and samples up to its stamp. Frames: "
      "W world (z up), B body (IMU). Without `has_pose` the numbers mean nothing.")
      .def_readonly("t_ns", &State::t_ns, "Stamp of the left image.")
      .def_property_readonly(
          "status",
          [](const State& state) {
            return kStatusNames.at(static_cast<std::size_t>(state.status));
          },
          "initialising, ok, degraded or lost.")
      .def_readonly("reason", &State::reason, "Why the status is not ok, or empty.")
      .def_readonly("has_pose", &State::has_pose)
      .def_property_readonly(
          "T_WB",
          [](const State& state) { return PoseMatrix(state.T_WB); },
          "Body to world, 4 x 4.")
      .def_property_readonly(
          "p",
          [](const State& state) { return ToArray(state.T_WB.p); },
          "Position of the body in the world [m].")
      .def_property_readonly(
          "q",
          [](const State& state) { return ToArray(state.T_WB.q); },
          "Rotation from body to world: quaternion w x y z.")
      .def_property_readonly("v", ArrayOf(&State::v_WB), "Velocity in the world [m/s].")
      .def_property_readonly("gyro_bias", ArrayOf(&State::gyro_bias), "[rad/s]")
      .def_property_readonly("accel_bias", ArrayOf(&State::accel_bias), "[m/s^2]")
      .def_property_readonly("sigma_p", ArrayOf(&State::sigma_p), "1-sigma [m].")
      .def_property_readonly("sigma_theta", ArrayOf(&State::sigma_theta), "1-sigma, in B [rad].")
      .def_property_readonly("sigma_v", ArrayOf(&State::sigma_v), "1-sigma [m/s].")
      .def_readonly("is_keyframe", &State::is_keyframe)
      .def_readonly("was_reset",
                    &State::was_reset,
                    "The state was given up after this frame; the next pose may jump.")
      .def_readonly("warning",
                    &State::warning,
                    "What is, or probably is, wrong with the calibration; else empty.")
      .def("__repr__", [](const State& state) {
        return "<facet.State " + std::to_string(state.t_ns) + " ns, " +
               kStatusNames.at(static_cast<std::size_t>(state.status)) + ">";
      });
}

void BindPlane(py::module_& module) {
  using api::Plane;
  py::class_<Plane>(module, "Plane", "n . p = d for its points in W.")
      .def_readonly("id", &Plane::id)
      .def_property_readonly(
          "n", [](const Plane& plane) { return ToArray(plane.n); }, "Unit normal.")
      .def_readonly("d", &Plane::d, "[m]")
      .def_readonly("label", &Plane::label, "floor, table, ceiling, wall or other.")
      .def_readonly("area_m2", &Plane::area_m2)
      .def_readonly("sigma_normal_rad", &Plane::sigma_normal_rad)
      .def_readonly("sigma_d_m", &Plane::sigma_d_m)
      .def_property_readonly(
          "outline",
          [](const py::object& self) { return RowsView(self.cast<Plane&>().outline, self); },
          "Convex, N x 3, counter-clockwise seen from where n points; a view.")
      .def("__repr__", [](const Plane& plane) {
        return "<facet.Plane " + std::to_string(plane.id) + ", " + plane.label + ">";
      });
}

}  // namespace

void BindVio(py::module_& module) {
  BindState(module);
  BindPlane(module);
  py::class_<Vio>(module, "Vio")
      .def(py::init(&MakeVio), py::arg("calibration"), py::arg("config"), py::arg("overrides"))
      .def_property_readonly(
          "notices", &Vio::Notices, "What the parameters held that has no effect any more.")
      .def(
          "on_pose",
          &Vio::OnPose,
          py::arg("observer"),
          "`observer(state)` is called within add_stereo as soon as the pose is known, before mesh "
          "and planes are worked on; None: nobody. It may not call this object. What it raises, "
          "add_stereo raises at its end.")
      .def("add_imu",
           &Vio::AddImu,
           py::arg("t_ns"),
           py::arg("gyro"),
           py::arg("accel"),
           "Takes the next sample, or the next N: stamps of the IMU's clock as integers, angular "
           "rates [rad/s] and specific forces [m/s^2] in B of the shape (3,) or (N, 3). Samples "
           "come "
           "in order of time.")
      .def(
          "add_stereo",
          &Vio::AddStereo,
          py::arg("t_ns"),
          py::arg("left"),
          py::arg("right"),
          py::kw_only(),
          py::arg("copy") = false,
          "A stereo pair with the stamp of the left image, after the IMU samples up to it; one "
          "sample beyond it is ideal. Images are uint8 of the shape (height, width); rows may be "
          "apart, and read-only arrays are fine. None: a missing image. The arrays are not copied: "
          "do not write to them before two more pairs were added, or say copy=True. Other threads "
          "go on meanwhile.")
      .def("mesh", &Vio::HorizonMesh, "The mesh over the last seconds, after the newest keyframe.")
      .def("map", &Vio::Map, "The mesh of the whole run so far; takes a moment.")
      .def("planes",
           &Vio::Planes,
           "The planes of the run so far: those in the estimator and retired ones, merged ones "
           "once. Takes as long as map().")
      .def_property_readonly("seconds_inside",
                             &Vio::seconds_inside,
                             "Wall time that the calls so far spent in Facet itself.");
}

}  // namespace facet::python
