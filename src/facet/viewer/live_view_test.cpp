// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/live_view.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <thread>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>

#include "facet/testing/io/test_sequence.h"
#include "facet/viewer/view_message.h"

namespace facet {
namespace {

using Tcp = boost::asio::ip::tcp;

StereoRig SmallRig() {
  StereoRig rig;
  CameraIntrinsics k;
  k.width = 64;
  k.height = 48;
  k.fx = k.fy = 50;
  k.cx = 32;
  k.cy = 24;
  rig.cameras = {CameraModel(k), CameraModel(k)};
  return rig;
}

LiveViewOptions AnyPort(const std::filesystem::path& result) {
  LiveViewOptions options;
  options.name = "test";
  options.result = result;
  options.server.port = 0;
  options.server.update_period = std::chrono::milliseconds(2);
  return options;
}

/// A keyframe with all there can be.
VioOutput Keyframe(std::int64_t ns) {
  VioOutput output;
  output.t = {ns};
  output.is_keyframe = output.has_pose = true;
  auto snapshot = std::make_shared<MapSnapshot>();
  snapshot->latest.t = output.t;
  snapshot->landmarks.push_back({LandmarkId{7}, Vector3d(0, 0, 2), 3, 0.1, {}});
  output.snapshot = snapshot;
  auto mesh = std::make_shared<MeshSnapshot>();
  mesh->t = output.t;
  mesh->mesh.vertices = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
  mesh->mesh.faces = {{0, 1, 2}};
  mesh->sigma_depth_m = {0.1, 0.2, 0.3};
  output.mesh = mesh;
  auto observations = std::make_shared<FrameObservations>();
  for (int i = 0; i < 4; ++i) {
    FeatureObservation feature;
    feature.landmark = LandmarkId{7 + i};
    feature.px_left = {10.0 + 20 * (i % 2), 10.0 + 25 * (i / 2)};
    observations->features.push_back(feature);
  }
  output.observations = observations;
  output.finished_keyframes.push_back({FrameId{0}, output.t, SE3()});
  return output;
}

FrameRecord RecordOf(const VioOutput& output) {
  FrameRecord record;
  record.t = output.t;
  record.has_pose = true;
  record.status = "ok";
  return record;
}

class Client {
 public:
  explicit Client(const LiveView& view) : socket_(context_) {
    const Tcp::endpoint endpoint(boost::asio::ip::make_address("127.0.0.1"),
                                 static_cast<std::uint16_t>(view.server().port()));
    socket_.next_layer().connect(endpoint);
    socket_.handshake("127.0.0.1:1", "/live");
  }

  /// The next message.
  std::string Read() {
    boost::beast::flat_buffer buffer;
    socket_.read(buffer);
    return boost::beast::buffers_to_string(buffer.data());
  }

  /// Reads until a message of this type comes.
  std::string ReadUntil(MessageType wanted) {
    while (true) {
      std::string bytes = Read();
      if (TypeOf(bytes) == wanted) return bytes;
    }
  }

  static MessageType TypeOf(const std::string& bytes) {
    std::uint16_t type = 0;
    std::memcpy(&type, bytes.data() + 6, sizeof(type));
    return static_cast<MessageType>(type);
  }

 private:
  boost::asio::io_context context_;
  boost::beast::websocket::stream<Tcp::socket> socket_;
};

TEST(LiveView, AClientThatComesLateGetsEverything) {
  const TempFolder folder;
  LiveView view(AnyPort(folder.path()), SmallRig());
  for (std::int64_t ns = 1; ns <= 200; ++ns) {
    view.AddImage({ns}, cv::Mat(48, 64, CV_8UC1, cv::Scalar(100)));
    view.Add(Keyframe(ns), RecordOf(Keyframe(ns)));
  }
  EXPECT_EQ(view.server().num_clients(), 0);
  EXPECT_FALSE(view.WantsSceneUpdate());  // nobody looks
  Client client(view);
  const std::string hello = client.ReadUntil(MessageType::kHello);
  EXPECT_NE(hello.find("\"mode\":\"live\""), std::string::npos);
  for (std::uint32_t group = 0; group < 4; ++group) {
    const std::string frames = client.ReadUntil(MessageType::kFrames);
    EXPECT_EQ(static_cast<std::uint32_t>(frames[24]), group);
  }
  client.ReadUntil(MessageType::kPoints);
  client.ReadUntil(MessageType::kMesh);
  client.ReadUntil(MessageType::kKeyframes);
  const std::string image = client.ReadUntil(MessageType::kImage);
  EXPECT_EQ(static_cast<unsigned char>(image[16]), 200);     // stamp
  EXPECT_NE(image.find("\xff\xd8\xff"), std::string::npos);  // JPEG
  EXPECT_TRUE(view.WantsSceneUpdate());
  EXPECT_FALSE(view.WantsSceneUpdate());  // not again so soon
}

TEST(LiveView, TheTruthLiesOverTheEstimateAndReachesThePageOnly) {
  const TempFolder folder;
  LiveViewOptions options = AnyPort(folder.path());
  constexpr std::int64_t kPeriod = 50'000'000;
  const SE3 T_GW(Quaterniond(Eigen::AngleAxisd(0.5, Vector3d::UnitZ())), {10, 20, 30});
  const auto place = [](int i) { return Vector3d(0.1 * i, 0.002 * i * i, std::sin(0.3 * i)); };
  for (int i = 0; i < 50; ++i)
    options.truth.push_back({{i * kPeriod}, T_GW * SE3(Quaterniond::Identity(), place(i))});
  LiveView view(options, SmallRig());
  for (int i = 0; i < 50; ++i) {
    VioOutput output;
    output.t = {i * kPeriod};
    FrameRecord record = RecordOf(output);
    record.state.T_WB.p = place(i);
    view.Add(output, record);
  }
  Client client(view);
  const std::string truth = client.ReadUntil(MessageType::kTruth);
  // Two blocks: 50 stamps, and 50 poses.
  const std::size_t poses = 32 + 8 + 50 * 8 + 8;
  ASSERT_EQ(truth.size(), poses + 50 * 7 * sizeof(float));
  for (int i = 0; i < 50; ++i) {
    std::array<float, 3> p{};
    std::memcpy(p.data(), truth.data() + poses + 7 * sizeof(float) * i, sizeof(p));
    EXPECT_LT((Vector3d(p[0], p[1], p[2]) - place(i)).norm(), 1e-5) << i;
  }
}

TEST(LiveView, TheMapFollowsInParts) {
  const TempFolder folder;
  LiveViewOptions options = AnyPort(folder.path());
  LiveView view(options, SmallRig());
  SurfaceMap map(options.map);
  ExpiredFace face;
  face.p_W = {Vector3d(0, 0, 1), Vector3d(1, 0, 1), Vector3d(0, 1, 1)};
  face.intensity = {50, 100, 150};
  face.sigma_depth_m = 0.02;
  map.Add(face);
  auto update = std::make_shared<SceneUpdate>();
  update->map_blocks = map.TakeChanged(100);
  update->planes.resize(1);
  VioOutput output = Keyframe(1);
  output.scene_update = update;
  view.Add(output, RecordOf(output));
  Client client(view);
  client.ReadUntil(MessageType::kPlanes);
  const std::string part = client.ReadUntil(MessageType::kMapPart);
  EXPECT_GT(part.size(), 200u);
}

TEST(LiveView, AfterTheRunItsFilesAreShown) {
  const TempFolder folder;
  LiveView view(AnyPort(folder.path()), SmallRig());
  Client client(view);
  client.ReadUntil(MessageType::kHello);
  RunRecord run;
  run.frames.push_back(RecordOf(Keyframe(5)));
  WriteResult(folder.path(), run);
  view.ShowResult(4, "it was lost");
  const std::string hello = client.ReadUntil(MessageType::kHello);
  EXPECT_NE(hello.find("\"mode\":\"finished\""), std::string::npos);
  EXPECT_NE(hello.find("T_BC0"), std::string::npos);
  client.ReadUntil(MessageType::kFrames);
  EXPECT_NE(client.ReadUntil(MessageType::kEnded).find("it was lost"), std::string::npos);
}

TEST(LiveView, AClientThatComesAfterTheRunGetsHelloFirst) {
  const TempFolder folder;
  LiveView view(AnyPort(folder.path()), SmallRig());
  {
    Client client(view);
    view.AddImage({5}, cv::Mat(48, 64, CV_8UC1, cv::Scalar(100)));
    view.Add(Keyframe(5), RecordOf(Keyframe(5)));
    client.ReadUntil(MessageType::kImage);
  }
  RunRecord run;
  run.frames.push_back(RecordOf(Keyframe(5)));
  WriteResult(folder.path(), run);
  view.ShowResult(0, "");
  Client client(view);
  EXPECT_EQ(Client::TypeOf(client.Read()), MessageType::kHello);
  EXPECT_EQ(Client::TypeOf(client.Read()), MessageType::kImage);
}

TEST(LiveView, AHistoryThatWasThinnedIsSentFromHelloOn) {
  const TempFolder folder;
  LiveView view(AnyPort(folder.path()), SmallRig());
  VioOutput plain;
  plain.has_pose = true;
  const auto add_frames = [&](std::int64_t begin, std::int64_t end) {
    for (plain.t.ns = begin; plain.t.ns < end; ++plain.t.ns)
      view.Add(plain, RecordOf(plain));
  };
  add_frames(1, 24500);
  Client early(view);
  early.ReadUntil(MessageType::kHello);
  early.ReadUntil(MessageType::kFrames);
  add_frames(24500, 24700);  // thins
  early.ReadUntil(MessageType::kHello);
  Client late(view);
  EXPECT_EQ(Client::TypeOf(late.Read()), MessageType::kHello);
  // Each group is newer than the one before: none of the longer history is left.
  std::int64_t newest = 0;
  while (newest < 24600) {
    const std::string frames = late.ReadUntil(MessageType::kFrames);
    std::int64_t stamp = 0;
    std::memcpy(&stamp, frames.data() + 16, sizeof(stamp));
    ASSERT_GT(stamp, newest);
    newest = stamp;
  }
}

TEST(FrameHistory, ALongRunIsThereFromItsBeginning) {
  FrameHistory history(100);
  for (std::int64_t ns = 0; ns < 10000; ++ns) {
    FrameRecord frame;
    frame.t = {ns};
    history.Add(frame);
  }
  const auto& frames = history.frames();
  EXPECT_LE(frames.size(), 100u);
  EXPECT_GT(history.num_thinned(), 50);
  EXPECT_EQ(frames.front().t.ns, 0);
  for (std::size_t i = 1; i < frames.size(); ++i)
    EXPECT_GT(frames[i].t, frames[i - 1].t);
  EXPECT_EQ(frames.back().t.ns, 9999);
  EXPECT_EQ(frames[frames.size() - 20].t.ns, 9980);
}

}  // namespace
}  // namespace facet
