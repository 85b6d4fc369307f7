// SPDX-License-Identifier: BSD-2-Clause
// Facet as a node of ROS 2 without ROS: Cyclone DDS with ROS 2's topics, types and services.
// Converts messages, and leaves the rest to RobotNode.
//
//   left/image_raw, right/image_raw (or .../compressed), imu, left/camera_info, right/camera_info
//     -> ~/odometry, ~/pose, ~/path, ~/mesh, ~/points, ~/map, ~/planes, /tf, /tf_static,
//     /diagnostics
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "arguments.h"
#include "dds_listener.h"
#include "entities.h"
#include "messages.h"
#include <pthread.h>
#include <unistd.h>

#include "facet/robot/robot_node.h"

namespace facet::dds {
namespace {

constexpr int kUsage = 2, kInput = 3;
constexpr double kDiagnosticsPeriod_s = 1;
constexpr Quality kService{true, false, 10, 100};

/// One of ~/start, ~/stop and ~/reset.
class TriggerService {
 public:
  using Act = robot::RobotNode::Answer (robot::RobotNode::*)();

  TriggerService(const Entity& participant,
                 const NodeNames& names,
                 const std::string& name,
                 Act act)
      : act_(act),
        calls_(participant, std_srvs_srv_dds__Trigger_Request__desc, names.Request(name), kService),
        answers_(
            participant, std_srvs_srv_dds__Trigger_Response__desc, names.Reply(name), kService) {}

  void Answer(robot::RobotNode& node) {
    while (const auto call = calls_.Take()) {
      const robot::RobotNode::Answer answer = (node.*act_)();
      std::string text = answer.text;
      WaitForCaller();
      answers_.Write({call->client, call->number, answer.is_done, text.data()});
    }
  }

  dds_entity_t handle() const { return calls_.handle(); }

 private:
  // A call may be here before the caller's ear for answers is known.
  void WaitForCaller() const {
    for (int i = 0; i < 20 && !answers_.HasReader(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  Act act_;
  Reader<TriggerRequest> calls_;
  Writer<TriggerResponse> answers_;
};

class Node {
 public:
  explicit Node(const Arguments& arguments)
      : names_(arguments.names),
        parameters_(robot::ReadParameters(arguments.parameters)),
        participant_(OpenParticipant()),
        listener_(participant_, names_, parameters_),
        robot_(parameters_.robot, listener_),
        imu_events_(participant_),
        image_events_(participant_),
        main_events_(participant_) {
    arguments.parameters.Get("reliable", is_reliable_);
    Subscribe();
    for (TriggerService& service : services_)
      main_events_.AddReader(service.handle(), [this, &service] { service.Answer(robot_); });
    main_events_.OnNewReader(listener_.map_writer(), [this] { robot_.RepeatMap(); });
    // Decoding images must not hold up the IMU, so each has a thread.
    imu_thread_ = std::thread([this] { Serve(imu_events_); });
    image_thread_ = std::thread([this] { Serve(image_events_); });
  }

  ~Node() {
    imu_events_.Stop();
    image_events_.Stop();
    imu_thread_.join();
    image_thread_.join();
  }

  /// Throws what a thread of the node has thrown.
  void Run() {
    main_events_.Run(
        [this] {
          listener_.Publish(robot_.Diagnose());
          if (listener_.TakeLackOfMap()) robot_.RepeatMap();
        },
        kDiagnosticsPeriod_s);
  }

  void Stop() { main_events_.Stop(); }

 private:
  void Serve(Dispatcher& events) {
    try {
      events.Run();
    } catch (...) {  // Run throws it
      main_events_.Fail(std::current_exception());
    }
  }

  void Subscribe() {
    Listen<Imu>(imu_events_,
                sensor_msgs_msg_dds__Imu__desc,
                "imu",
                parameters_.imu_queue,
                [this](const auto& message) { robot_.AddImu(ToSample(*message)); });
    for (int camera = 0; camera < 2; ++camera)
      SubscribeCamera(camera, camera == 0 ? "left" : "right");
  }

  void SubscribeCamera(int camera, const std::string& side) {
    const int queue = parameters_.image_queue;
    if (parameters_.has_compressed_images) {
      SubscribeImages<CompressedImage>(camera,
                                       sensor_msgs_msg_dds__CompressedImage__desc,
                                       side + "/image_raw/compressed",
                                       queue);
    } else {
      SubscribeImages<Image>(camera, sensor_msgs_msg_dds__Image__desc, side + "/image_raw", queue);
    }
    Listen<CameraInfo>(image_events_,
                       sensor_msgs_msg_dds__CameraInfo__desc,
                       side + "/camera_info",
                       10,
                       [this, camera](const auto& message) {
                         robot_.AddCameraInfo(camera, ToCameraInfo(*message));
                       });
  }

  template <class Message>
  void SubscribeImages(int camera,
                       const dds_topic_descriptor_t& type,
                       const std::string& name,
                       int queue) {
    auto reader = Open<Message>(type, name, queue);
    take_image_[camera] = [reader]() -> std::optional<robot::ReceivedImage> {
      if (const auto message = reader->Take()) return ToImage(message);
      return std::nullopt;
    };
    image_events_.AddReader(reader->handle(), [this] { TakeImages(); });
  }

  // Of what waits, the oldest first: with a backlog, images of one camera alone would be given up
  // before their partners come.
  void TakeImages() {
    while (!image_events_.is_stopped()) {
      for (int camera = 0; camera < 2; ++camera) {
        if (!next_image_[camera] && take_image_[camera])
          next_image_[camera] = take_image_[camera]();
      }
      if (!next_image_[0] && !next_image_[1]) return;
      const int camera =
          !next_image_[0] || (next_image_[1] && next_image_[1]->t_ns < next_image_[0]->t_ns) ? 1
                                                                                             : 0;
      const robot::ReceivedImage image = *std::exchange(next_image_[camera], std::nullopt);
      robot_.AddImage(camera, image);
    }
  }

  template <class Message, class Use>
  void Listen(Dispatcher& events,
              const dds_topic_descriptor_t& type,
              const std::string& name,
              int queue,
              Use use) {
    auto reader = Open<Message>(type, name, queue);
    events.AddReader(reader->handle(), [reader, use] {
      while (const auto message = reader->Take())
        use(message);
    });
  }

  template <class Message>
  std::shared_ptr<Reader<Message>> Open(const dds_topic_descriptor_t& type,
                                        const std::string& name,
                                        int queue) const {
    const Quality quality{is_reliable_, false, queue, 0};
    return std::make_shared<Reader<Message>>(participant_, type, names_.Topic(name), quality);
  }

  const NodeNames names_;
  const robot::NodeParameters parameters_;
  bool is_reliable_ = false;
  Entity participant_;
  DdsListener listener_;
  robot::RobotNode robot_;
  std::array<std::function<std::optional<robot::ReceivedImage>()>, 2> take_image_;
  std::array<std::optional<robot::ReceivedImage>, 2> next_image_;
  Dispatcher imu_events_, image_events_, main_events_;
  std::vector<TriggerService> services_ = Services();
  std::thread imu_thread_, image_thread_;

  std::vector<TriggerService> Services() const {
    std::vector<TriggerService> services;
    services.emplace_back(participant_, names_, "~/start", &robot::RobotNode::Start);
    services.emplace_back(participant_, names_, "~/stop", &robot::RobotNode::Stop);
    services.emplace_back(participant_, names_, "~/reset", &robot::RobotNode::Reset);
    return services;
  }
};

int Complain(const std::exception& error, int exit_code) {
  std::fprintf(stderr, "facet-dds: %s\n", error.what());
  return exit_code;
}

/// Signals that end the node, from now on for a thread that waits for them.
sigset_t BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// Stops the node at the first of the signals.
class SignalWatch {
 public:
  SignalWatch(const sigset_t& signals, Node& node)
      : thread_([signals, &node] {
          int signal = 0;
          sigwait(&signals, &signal);
          node.Stop();
        }) {}

  /// Where none has come the thread still waits, and gets one.
  ~SignalWatch() {
    kill(getpid(), SIGTERM);
    thread_.join();
  }
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

 private:
  std::thread thread_;
};

int Run(const std::vector<std::string>& words) {
  const sigset_t signals = BlockSignals();
  try {
    const Arguments arguments = ReadArguments(words);
    if (arguments.wants_help) {
      std::fputs(kUsageText, stdout);
      return 0;
    }
    Node node(arguments);
    const SignalWatch watch(signals, node);
    node.Run();
    return 0;
  } catch (const robot::CalibrationError& error) {
    return Complain(error, kInput);
  } catch (const api::Error& error) {
    return Complain(error, kUsage);
  } catch (const std::exception& error) {
    return Complain(error, 1);
  }
}

}  // namespace
}  // namespace facet::dds

int main(int argc, char** argv) {
  facet::api::ForbidOpenCvThreads();
  return facet::dds::Run({argv + 1, argv + argc});
}
