// SPDX-License-Identifier: BSD-2-Clause
// The other side of facet-dds in its tests: plays messages whose bytes somebody else made, and
// writes down the bytes of those that come, so that neither is made by the code under test.
//
//   dds_peer play FILE SPEED             FILE: records, played in the rhythm of their times; ends
//   when all have arrived dds_peer listen FILE TOPIC TYPE...   until SIGTERM; latched topics by
//   "TOPIC!" dds_peer call SERVICE                prints "true TEXT" or "false TEXT"
//
// A record: time in ns (8 bytes), and topic, type and message, each with its length in 4 bytes
// before it.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "entities.h"
#include "messages.h"
#include <dds/ddsi/ddsi_serdata.h>

#include "facet/facet.h"

namespace facet::dds {
namespace {

const std::map<std::string, const dds_topic_descriptor_t*>& Types() {
  static const std::map<std::string, const dds_topic_descriptor_t*> kTypes = {
      {"sensor_msgs/msg/Imu", &sensor_msgs_msg_dds__Imu__desc},
      {"sensor_msgs/msg/Image", &sensor_msgs_msg_dds__Image__desc},
      {"sensor_msgs/msg/CompressedImage", &sensor_msgs_msg_dds__CompressedImage__desc},
      {"sensor_msgs/msg/CameraInfo", &sensor_msgs_msg_dds__CameraInfo__desc},
      {"sensor_msgs/msg/PointCloud2", &sensor_msgs_msg_dds__PointCloud2__desc},
      {"nav_msgs/msg/Odometry", &nav_msgs_msg_dds__Odometry__desc},
      {"nav_msgs/msg/Path", &nav_msgs_msg_dds__Path__desc},
      {"geometry_msgs/msg/PoseWithCovarianceStamped",
       &geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc},
      {"visualization_msgs/msg/Marker", &visualization_msgs_msg_dds__Marker__desc},
      {"visualization_msgs/msg/MarkerArray", &visualization_msgs_msg_dds__MarkerArray__desc},
      {"tf2_msgs/msg/TFMessage", &tf2_msgs_msg_dds__TFMessage__desc},
      {"diagnostic_msgs/msg/DiagnosticArray", &diagnostic_msgs_msg_dds__DiagnosticArray__desc}};
  return kTypes;
}

const dds_topic_descriptor_t& TypeOf(const std::string& name) {
  const auto found = Types().find(name);
  if (found == Types().end()) throw api::Error("no type " + name);
  return *found->second;
}

struct Record {
  std::int64_t t_ns = 0;
  std::string topic, type, bytes;
};

std::string ReadText(std::istream& stream) {
  std::uint32_t size = 0;
  stream.read(reinterpret_cast<char*>(&size), sizeof size);
  std::string text(stream ? size : 0, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

void WriteText(std::ostream& stream, const std::string& text) {
  const auto size = static_cast<std::uint32_t>(text.size());
  stream.write(reinterpret_cast<const char*>(&size), sizeof size);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
}

std::vector<Record> ReadRecords(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<Record> records;
  for (;;) {
    Record record;
    stream.read(reinterpret_cast<char*>(&record.t_ns), sizeof record.t_ns);
    record.topic = ReadText(stream);
    record.type = ReadText(stream);
    record.bytes = ReadText(stream);
    if (!stream) return records;
    records.push_back(std::move(record));
  }
}

struct SerdataDeleter {
  void operator()(ddsi_serdata* data) const { ddsi_serdata_unref(data); }
};
using Serdata = std::unique_ptr<ddsi_serdata, SerdataDeleter>;

/// Sends bytes. What they are to DDS is taken from an empty message that is sent to nobody but this
/// program.
class ByteWriter {
 public:
  ByteWriter(const Entity& participant, const std::string& type, const std::string& topic)
      : writer_(
            participant, Endpoint::Kind::kWriter, TypeOf(type), topic, {true, false, 1000, 10000}) {
    const Quality latched{true, true, 1, 0};
    const std::string own = "facet_dds_peer_" + type;
    const Endpoint in(participant, Endpoint::Kind::kReader, TypeOf(type), own, latched);
    const Endpoint out(participant, Endpoint::Kind::kWriter, TypeOf(type), own, latched);
    const std::vector<std::uint64_t> nothing(TypeOf(type).m_size / 8 + 1);
    dds_write(out.handle(), nothing.data());
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info;
    for (int i = 0; i < 500 && data == nullptr; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (dds_takecdr(in.handle(), &data, 1, &info, DDS_ANY_STATE) < 1) data = nullptr;
    }
    if (data == nullptr) throw api::Error("no message of type " + type + " of its own");
    example_.reset(data);
  }

  void WaitForReader() const {
    while (!writer_.HasPeer())
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  void Write(const std::string& bytes) const {
    std::string copy = bytes;
    const ddsrt_iovec_t part{copy.data(), copy.size()};
    Serdata data(ddsi_serdata_from_ser_iov(
        example_->type, SDK_DATA, 1, &part, static_cast<std::size_t>(copy.size())));
    if (!data) throw api::Error("these bytes are no " + writer_.topic());
    data->timestamp.v = dds_time();
    data->statusinfo = 0;
    if (dds_forwardcdr(writer_.handle(), data.release()) < 0)
      throw api::Error("not sent: " + writer_.topic());
  }

  void WaitForAll() const { dds_wait_for_acks(writer_.handle(), DDS_SECS(20)); }

 private:
  Endpoint writer_;
  Serdata example_;
};

int Play(const Entity& participant, const std::string& file, double speed) {
  using Clock = std::chrono::steady_clock;
  const std::vector<Record> records = ReadRecords(file);
  std::map<std::string, ByteWriter> writers;
  for (const Record& record : records) {
    if (writers.count(record.topic) == 0)
      writers.emplace(std::piecewise_construct,
                      std::forward_as_tuple(record.topic),
                      std::forward_as_tuple(participant, record.type, record.topic));
  }
  for (const auto& [topic, writer] : writers)
    writer.WaitForReader();
  const auto start = Clock::now();
  for (const Record& record : records) {
    const double wait_s = static_cast<double>(record.t_ns - records.front().t_ns) * 1e-9 / speed;
    std::this_thread::sleep_until(
        start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait_s)));
    writers.at(record.topic).Write(record.bytes);
  }
  for (const auto& [topic, writer] : writers)
    writer.WaitForAll();
  return 0;
}

std::atomic<bool> is_over{false};

int Listen(const Entity& participant,
           const std::string& file,
           const std::vector<std::string>& words) {
  std::ofstream stream(file, std::ios::binary);
  struct Ear {
    std::string type;
    Endpoint end;
  };
  std::vector<Ear> ears;
  for (std::size_t i = 0; i + 1 < words.size(); i += 2) {
    const bool is_latched = words[i].back() == '!';
    const std::string topic = words[i].substr(0, words[i].size() - (is_latched ? 1 : 0));
    ears.push_back({words[i + 1],
                    Endpoint(participant,
                             Endpoint::Kind::kReader,
                             TypeOf(words[i + 1]),
                             topic,
                             {true, is_latched, 10000, 0})});
  }
  std::signal(SIGTERM, [](int) { is_over = true; });
  while (!is_over) {
    for (const Ear& ear : ears) {
      ddsi_serdata* data = nullptr;
      dds_sample_info_t info;
      while (dds_takecdr(ear.end.handle(), &data, 1, &info, DDS_ANY_STATE) > 0) {
        const Serdata owner(data);
        if (!info.valid_data) continue;
        std::string bytes(ddsi_serdata_size(data), '\0');
        ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
        stream.write(reinterpret_cast<const char*>(&info.source_timestamp),
                     sizeof info.source_timestamp);
        WriteText(stream, ear.end.topic());
        WriteText(stream, ear.type);
        WriteText(stream, bytes);
      }
    }
    stream.flush();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return 0;
}

int Call(const Entity& participant, const std::string& service) {
  const Quality quality{true, false, 10, 100};
  const Writer<TriggerRequest> calls(
      participant, std_srvs_srv_dds__Trigger_Request__desc, "rq" + service + "Request", quality);
  Reader<TriggerResponse> answers(
      participant, std_srvs_srv_dds__Trigger_Response__desc, "rr" + service + "Reply", quality);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  bool is_sent = false;
  while (std::chrono::steady_clock::now() < end) {
    dds_subscription_matched_status_t status;
    const bool is_heard = dds_get_subscription_matched_status(answers.handle(), &status) >= 0 &&
                          status.current_count > 0 && calls.HasReader();
    if (is_heard && !is_sent) is_sent = calls.Write({77, 5, 0});
    while (const auto answer = answers.Take()) {
      if (answer->client != 77 || answer->number != 5) continue;
      std::printf("%s %s\n", answer->success ? "true" : "false", answer->message);
      return 0;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw api::Error("nobody answers " + service);
}

int Run(const std::vector<std::string>& words) {
  const Entity participant = OpenParticipant();
  if (words.size() == 3 && words[0] == "play")
    return Play(participant, words[1], std::stod(words[2]));
  if (words.size() >= 4 && words[0] == "listen")
    return Listen(participant, words[1], {words.begin() + 2, words.end()});
  if (words.size() == 2 && words[0] == "call") return Call(participant, words[1]);
  throw api::Error("usage: dds_peer play FILE SPEED | listen FILE TOPIC TYPE... | call SERVICE");
}

}  // namespace
}  // namespace facet::dds

int main(int argc, char** argv) {
  try {
    return facet::dds::Run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dds_peer: %s\n", error.what());
    return 1;
  }
}
