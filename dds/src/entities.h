// SPDX-License-Identifier: BSD-2-Clause
// Cyclone DDS as the node uses it: typed readers and writers of ROS 2's topics that end by
// themselves.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <dds/dds.h>

namespace facet::dds {

/// Ends the entity with itself.
class Entity {
 public:
  Entity() = default;
  /// Throws api::Error, "... `what` ...", where the handle is an error.
  Entity(dds_entity_t handle, const std::string& what);
  ~Entity();
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept;
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  dds_entity_t handle() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

/// In the domain that ROS_DOMAIN_ID names, else in 0, with the configuration of CYCLONEDDS_URI.
/// Throws api::Error.
Entity OpenParticipant();

/// What of ROS 2's quality of service the node chooses.
struct Quality {
  bool is_reliable = true;
  bool is_latched = false;  ///< transient local: late readers get the newest ones
  std::int32_t depth = 10;  ///< newest samples that are kept
  /// How long a writer waits where a reliable reader does not keep up, before it drops the sample.
  std::int64_t patience_ms = 0;
};

/// The untyped half of readers and writers: a topic "rt/..." and its end.
class Endpoint {
 public:
  enum class Kind { kReader, kWriter };

  /// Throws api::Error.
  Endpoint(const Entity& participant,
           Kind kind,
           const dds_topic_descriptor_t& type,
           const std::string& topic,
           const Quality& quality);

  dds_entity_t handle() const { return end_.handle(); }
  const std::string& topic() const { return name_; }
  bool HasPeer() const;  ///< of a writer: whether anybody reads

 private:
  std::string name_;
  Entity topic_, end_;
};

template <class Message>
class Writer {
 public:
  Writer(const Entity& participant,
         const dds_topic_descriptor_t& type,
         const std::string& topic,
         const Quality& quality)
      : end_(participant, Endpoint::Kind::kWriter, type, topic, quality) {}

  /// Thread-safe. False if it was dropped, because a reader does not keep up.
  bool Write(const Message& message) const { return dds_write(end_.handle(), &message) >= 0; }
  bool HasReader() const { return end_.HasPeer(); }
  dds_entity_t handle() const { return end_.handle(); }

 private:
  Endpoint end_;
};

template <class Message>
class Reader {
 public:
  Reader(const Entity& participant,
         const dds_topic_descriptor_t& type,
         const std::string& topic,
         const Quality& quality)
      : type_(&type), end_(participant, Endpoint::Kind::kReader, type, topic, quality) {}

  /// The next message, which lives as long as it is held; null where there is none.
  std::shared_ptr<const Message> Take() {
    const dds_topic_descriptor_t* type = type_;
    auto* message = static_cast<Message*>(dds_alloc(sizeof(Message)));
    std::shared_ptr<const Message> owner(
        message, [type](Message* gone) { dds_sample_free(gone, type, DDS_FREE_ALL); });
    void* sample = message;
    dds_sample_info_t info;
    while (dds_take(end_.handle(), &sample, &info, 1, 1) > 0) {
      if (info.valid_data) return owner;
    }
    return nullptr;
  }

  dds_entity_t handle() const { return end_.handle(); }

 private:
  const dds_topic_descriptor_t* type_;
  Endpoint end_;
};

/// Calls what belongs to entities whose time has come, on the thread that calls Run.
class Dispatcher {
 public:
  explicit Dispatcher(const Entity& participant);

  /// `take` is called when the reader has data, and takes all of them.
  void AddReader(dds_entity_t reader, std::function<void()> take);
  /// `act` is called when a new reader listens to a writer.
  void OnNewReader(dds_entity_t writer, std::function<void()> act);

  /// Until Stop. Calls `tick` each period, if there is one.
  void Run(const std::function<void()>& tick = {}, double period_s = 1);
  /// From any thread.
  void Stop();
  bool is_stopped() const { return is_stopped_; }
  /// The same, and Run throws this.
  void Fail(std::exception_ptr error);

 private:
  void Add(dds_entity_t entity, std::uint32_t status, std::function<void()> act);

  Entity guard_, waitset_;
  std::vector<std::function<void()>> acts_;
  std::atomic<bool> is_stopped_{false};
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace facet::dds
