// SPDX-License-Identifier: BSD-2-Clause
#include "entities.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>

#include "facet/facet.h"

namespace facet::dds {

namespace {

constexpr dds_domainid_t kLastDomain = 232;  // the ports of a higher one do not exist

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

std::unique_ptr<dds_qos_t, QosDeleter> ToQos(const Quality& quality) {
  std::unique_ptr<dds_qos_t, QosDeleter> qos(dds_create_qos());
  dds_qset_reliability(qos.get(),
                       quality.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(quality.patience_ms));
  dds_qset_durability(
      qos.get(), quality.is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  if (quality.is_latched)
    dds_qset_durability_service(qos.get(),
                                0,
                                DDS_HISTORY_KEEP_LAST,
                                quality.depth,
                                DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
  // As rmw_cyclonedds: instances are not forgotten when their writer ends.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

}  // namespace

Entity::Entity(dds_entity_t handle, const std::string& what) : handle_(handle) {
  if (handle < 0) {
    handle_ = 0;
    throw api::Error("DDS: no " + what + " (" + dds_strretcode(-handle) + ")");
  }
}

Entity::~Entity() {
  if (handle_ > 0) dds_delete(handle_);
}

Entity& Entity::operator=(Entity&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}

Entity OpenParticipant() {
  dds_domainid_t domain = 0;
  if (const char* text = std::getenv("ROS_DOMAIN_ID"); text != nullptr && *text != '\0') {
    const char* end = text + std::strlen(text);
    const auto [rest, error] = std::from_chars(text, end, domain);
    if (error != std::errc() || rest != end || domain > kLastDomain)
      throw api::Error(std::string("ROS_DOMAIN_ID must be from 0 to 232, not ") + text);
  }
  // Without this a writer that one reader does not answer stops after 30 kB, for all readers.
  std::string configuration =
      "<CycloneDDS><Domain><Internal><Watermarks><WhcHigh>8 MB</WhcHigh>"
      "<WhcHighInit>8 MB</WhcHighInit><WhcAdaptive>false</WhcAdaptive></Watermarks></Internal>"
      "</Domain></CycloneDDS>";
  if (const char* more = std::getenv("CYCLONEDDS_URI"); more != nullptr && *more != '\0')
    configuration += std::string(",") + more;
  const dds_entity_t created = dds_create_domain(domain, configuration.c_str());
  if (created < 0 && created != DDS_RETCODE_PRECONDITION_NOT_MET)
    throw api::Error(std::string("DDS: no domain; is CYCLONEDDS_URI right? (") +
                     dds_strretcode(-created) + ")");
  return Entity(dds_create_participant(domain, nullptr, nullptr), "participant");
}

Endpoint::Endpoint(const Entity& participant,
                   Kind kind,
                   const dds_topic_descriptor_t& type,
                   const std::string& topic,
                   const Quality& quality)
    : name_(topic) {
  const auto qos = ToQos(quality);
  topic_ = Entity(dds_create_topic(participant.handle(), &type, topic.c_str(), qos.get(), nullptr),
                  "topic " + topic);
  end_ = kind == Kind::kReader
             ? Entity(dds_create_reader(participant.handle(), topic_.handle(), qos.get(), nullptr),
                      "reader of " + topic)
             : Entity(dds_create_writer(participant.handle(), topic_.handle(), qos.get(), nullptr),
                      "writer of " + topic);
}

bool Endpoint::HasPeer() const {
  return dds_get_matched_subscriptions(end_.handle(), nullptr, 0) > 0;
}

Dispatcher::Dispatcher(const Entity& participant)
    : guard_(dds_create_guardcondition(participant.handle()), "guard condition"),
      waitset_(dds_create_waitset(participant.handle()), "waitset") {
  dds_waitset_attach(waitset_.handle(), guard_.handle(), -1);
}

void Dispatcher::AddReader(dds_entity_t reader, std::function<void()> take) {
  Add(reader, DDS_DATA_AVAILABLE_STATUS, std::move(take));
}

void Dispatcher::OnNewReader(dds_entity_t writer, std::function<void()> act) {
  Add(writer, DDS_PUBLICATION_MATCHED_STATUS, [writer, act = std::move(act)] {
    dds_publication_matched_status_t status;
    if (dds_get_publication_matched_status(writer, &status) >= 0 && status.total_count_change > 0)
      act();
  });
}

void Dispatcher::Add(dds_entity_t entity, std::uint32_t status, std::function<void()> act) {
  dds_set_status_mask(entity, status);
  acts_.push_back(std::move(act));
  dds_waitset_attach(waitset_.handle(), entity, static_cast<dds_attach_t>(acts_.size() - 1));
}

void Dispatcher::Run(const std::function<void()>& tick, double period_s) {
  using Clock = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_s));
  auto next = Clock::now();
  std::vector<dds_attach_t> due(acts_.size() + 1);
  while (!is_stopped_) {
    const auto now = Clock::now();
    if (tick && now >= next) {
      tick();
      next = std::max(next + period, now);
    }
    const auto wait =
        tick ? std::chrono::duration_cast<std::chrono::nanoseconds>(next - Clock::now()).count()
             : std::int64_t{DDS_INFINITY};
    const dds_return_t num = dds_waitset_wait(
        waitset_.handle(), due.data(), due.size(), std::max<std::int64_t>(wait, 0));
    for (dds_return_t i = 0; i < num && !is_stopped_; ++i) {
      const dds_attach_t act = due[static_cast<std::size_t>(i)];
      if (act >= 0) acts_[static_cast<std::size_t>(act)]();
    }
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

void Dispatcher::Fail(std::exception_ptr error) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = std::move(error);
  }
  Stop();
}

void Dispatcher::Stop() {
  is_stopped_ = true;
  dds_set_guardcondition(guard_.handle(), true);
}

}  // namespace facet::dds
