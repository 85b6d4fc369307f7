// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/scene_messages.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <nlohmann/json.hpp>

#include "facet/io/json_file.h"
#include "facet/map/tracking_status.h"

namespace facet {
namespace {

template <class T>
void AddRows(ViewMessage& message, BlockName name, const std::vector<T>& numbers, int per_row) {
  if (!numbers.empty()) message.Add(name, std::span<const T>(numbers), per_row);
}

void Append(const Vector3d& v, std::vector<float>& row) {
  for (int i = 0; i < 3; ++i)
    row.push_back(static_cast<float>(v[i]));
}

void Append(const SE3& T, std::vector<float>& row) {
  Append(T.p, row);
  for (double component : {T.q.w(), T.q.x(), T.q.y(), T.q.z()})
    row.push_back(static_cast<float>(component));
}

std::vector<std::int8_t> PackedNormals(std::span<const Vector3d> normals) {
  std::vector<std::int8_t> packed;
  packed.reserve(4 * normals.size());
  for (const Vector3d& n : normals) {
    for (int i = 0; i < 3; ++i) {
      const double component = std::isfinite(n[i]) ? std::clamp(n[i], -1.0, 1.0) : 0;
      packed.push_back(static_cast<std::int8_t>(std::lround(127 * component)));
    }
    packed.push_back(0);
  }
  return packed;
}

std::uint32_t StatusNumber(const std::string& status) {
  for (TrackingStatus s : {TrackingStatus::kInitialising,
                           TrackingStatus::kOk,
                           TrackingStatus::kDegraded,
                           TrackingStatus::kLost}) {
    if (status == ToString(s)) return static_cast<std::uint32_t>(s);
  }
  return static_cast<std::uint32_t>(TrackingStatus::kOk);
}

std::uint32_t FlagsOf(const FrameRecord& f) {
  return (f.has_pose ? 1U : 0U) | (f.is_keyframe ? 2U : 0U) | StatusNumber(f.status) << 8 |
         static_cast<std::uint32_t>(f.segment) << 16;
}

/// The reasons of frames that are not ok, by their row.
std::string ReasonsOf(std::span<const FrameRecord> frames) {
  nlohmann::ordered_json reasons = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].reason.empty()) reasons[std::to_string(i)] = frames[i].reason;
  }
  return JsonText(reasons);
}

nlohmann::ordered_json NumbersOf(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

std::vector<float> FloatsOf(std::span<const Vector3d> points) {
  std::vector<float> floats;
  floats.reserve(3 * points.size());
  for (const Vector3d& p : points)
    Append(p, floats);
  return floats;
}

std::string MeshMessage(const ViewMessage::Header& header,
                        const TriangleMesh& mesh,
                        std::span<const float> error_m,
                        const std::optional<std::array<std::int32_t, 3>>& key) {
  ViewMessage message(header);
  if (key) message.Add(BlockName::kKey, std::span<const std::int32_t>(*key), 3);
  AddRows(message, BlockName::kPositions, FloatsOf(mesh.vertices), 3);
  AddRows(message, BlockName::kNormals, PackedNormals(mesh.normals), 4);
  std::vector<std::uint8_t> colours;
  for (const auto& colour : mesh.colours)
    colours.insert(colours.end(), {colour[0], colour[1], colour[2], 255});
  AddRows(message, BlockName::kColours, colours, 4);
  std::vector<std::uint32_t> faces;
  for (const auto& face : mesh.faces) {
    for (int corner : face)
      faces.push_back(static_cast<std::uint32_t>(corner));
  }
  AddRows(message, BlockName::kFaces, faces, 3);
  AddRows(message, BlockName::kPlaneIds, mesh.plane_ids, 1);
  AddRows(message, BlockName::kSigma, mesh.sigma_m, 1);
  if (!error_m.empty()) message.Add(BlockName::kError, error_m, 1);
  return message.Finish();
}

std::string FramesMessage(const ViewMessage::Header& header, std::span<const FrameRecord> frames) {
  std::vector<std::int64_t> stamps;
  std::vector<float> poses, motion, sigmas, stages, counts;
  std::vector<std::uint32_t> flags;
  for (const FrameRecord& f : frames) {
    stamps.push_back(f.t.ns);
    Append(f.state.T_WB, poses);
    for (const Vector3d* v : {&f.state.v_WB, &f.state.bias.b_g, &f.state.bias.b_a})
      Append(*v, motion);
    for (const Vector3d* v : {&f.sigma_p, &f.sigma_theta, &f.sigma_v, &f.sigma_b_g, &f.sigma_b_a})
      Append(*v, sigmas);
    flags.push_back(FlagsOf(f));
    for (double ms : f.times.ms)
      stages.push_back(static_cast<float>(ms));
    for (double value : {f.wall_ms,
                         f.latency_ms,
                         1.0 * f.num_landmarks,
                         1.0 * f.num_planes,
                         1.0 * f.num_constraints})
      counts.push_back(static_cast<float>(value));
  }
  ViewMessage message(header);
  AddRows(message, BlockName::kStamps, stamps, 1);
  AddRows(message, BlockName::kPoses, poses, 7);
  AddRows(message, BlockName::kMotion, motion, 9);
  AddRows(message, BlockName::kSigmas, sigmas, 15);
  AddRows(message, BlockName::kFlags, flags, 1);
  AddRows(message, BlockName::kStages, stages, static_cast<int>(kNumStages));
  AddRows(message, BlockName::kCounts, counts, 5);
  message.AddText(ReasonsOf(frames));
  return message.Finish();
}

std::string PosesMessage(const ViewMessage::Header& header, std::span<const StampedPose> poses) {
  std::vector<std::int64_t> stamps;
  std::vector<float> numbers;
  for (const StampedPose& pose : poses) {
    stamps.push_back(pose.t.ns);
    Append(pose.T_WB, numbers);
  }
  ViewMessage message(header);
  AddRows(message, BlockName::kStamps, stamps, 1);
  AddRows(message, BlockName::kPoses, numbers, 7);
  return message.Finish();
}

std::string PlanesMessage(const ViewMessage::Header& header,
                          std::span<const EstimatedPlane> planes) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const EstimatedPlane& plane : planes) {
    nlohmann::ordered_json outline = nlohmann::ordered_json::array();
    for (const Vector3d& corner : plane.outline_W)
      outline.push_back(NumbersOf(corner));
    list.push_back({{"id", plane.id},
                    {"n", NumbersOf(plane.n_W)},
                    {"d", plane.d_W},
                    {"centre", NumbersOf(plane.centre_W)},
                    {"orientation", plane.orientation},
                    {"label", plane.label},
                    {"area_m2", plane.area_m2},
                    {"sigma_normal_rad", plane.sigma_normal_rad},
                    {"sigma_d_m", plane.sigma_d_m},
                    {"landmarks", plane.num_landmarks},
                    {"outline", outline}});
  }
  return TextMessage(header, JsonText(list));
}

std::string TextMessage(const ViewMessage::Header& header, const std::string& text) {
  ViewMessage message(header);
  message.AddText(text);
  return message.Finish();
}

}  // namespace facet
