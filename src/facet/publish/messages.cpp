// SPDX-License-Identifier: BSD-2-Clause
#include "facet/publish/messages.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "facet/viewer/base64.h"

namespace facet {

namespace {

// The texts of large meshes are written directly: a tree of JSON values takes ten times as long.
void Append(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), std::isfinite(value) ? value : 0);
  text.append(digits.data(), end.ptr);
}

// Enough for whatever is drawn: a tenth of a millimetre in a hundred metres.
void AppendShort(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(),
                                 digits.data() + digits.size(),
                                 static_cast<float>(std::isfinite(value) ? value : 0));
  text.append(digits.data(), end.ptr);
}

void Append(std::string& text, std::int64_t value) {
  text += std::to_string(value);
}

void AppendText(std::string& text, std::string_view value) {
  text += '"';
  for (const char c : value) {
    const bool is_plain = static_cast<unsigned char>(c) >= 0x20 && c != '"' && c != '\\';
    text += is_plain ? c : '_';
  }
  text += '"';
}

void AppendTime(std::string& text, Timestamp t) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = std::max<std::int64_t>(t.ns, 0);
  text += "{\"sec\":";
  Append(text, ns / kSecond);
  text += ",\"nsec\":";
  Append(text, ns % kSecond);
  text += '}';
}

void AppendHead(std::string& text, Timestamp t, std::string_view frame) {
  text += "{\"timestamp\":";
  AppendTime(text, t);
  text += ",\"frame_id\":";
  AppendText(text, frame);
}

void AppendVector(std::string& text, const Vector3d& v) {
  text += "{\"x\":";
  Append(text, v.x());
  text += ",\"y\":";
  Append(text, v.y());
  text += ",\"z\":";
  Append(text, v.z());
  text += '}';
}

void AppendShortVector(std::string& text, const Vector3d& v) {
  text += "{\"x\":";
  AppendShort(text, v.x());
  text += ",\"y\":";
  AppendShort(text, v.y());
  text += ",\"z\":";
  AppendShort(text, v.z());
  text += '}';
}

void AppendQuaternion(std::string& text, const Quaterniond& q) {
  text += "{\"x\":";
  Append(text, q.x());
  text += ",\"y\":";
  Append(text, q.y());
  text += ",\"z\":";
  Append(text, q.z());
  text += ",\"w\":";
  Append(text, q.w());
  text += '}';
}

void AppendPose(std::string& text, const SE3& T) {
  text += "{\"position\":";
  AppendVector(text, T.p);
  text += ",\"orientation\":";
  AppendQuaternion(text, T.q);
  text += '}';
}

struct Colour {
  double r = 0.7, g = 0.7, b = 0.7, a = 1;
};

void AppendColour(std::string& text, const Colour& colour) {
  text += "{\"r\":";
  AppendShort(text, colour.r);
  text += ",\"g\":";
  AppendShort(text, colour.g);
  text += ",\"b\":";
  AppendShort(text, colour.b);
  text += ",\"a\":";
  AppendShort(text, colour.a);
  text += '}';
}

/// Elements of an array, apart by commas.
template <class Items, class AppendItem>
void AppendList(std::string& text, const Items& items, const AppendItem& append_item) {
  text += '[';
  bool is_first = true;
  for (const auto& item : items) {
    if (!is_first) text += ',';
    is_first = false;
    append_item(item);
  }
  text += ']';
}

// The schema wants every kind of primitive to be named.
void AppendEntityHead(std::string& text, Timestamp t, std::string_view id) {
  AppendHead(text, t, kWorldFrame);
  text += ",\"id\":";
  AppendText(text, id);
  text +=
      ",\"lifetime\":{\"sec\":0,\"nsec\":0},\"frame_locked\":true,\"metadata\":[],\"arrows\":[],"
      "\"cubes\":[],\"spheres\":[],\"cylinders\":[],\"models\":[]";
}

void AppendTriangles(std::string& text, const TriangleMesh& mesh) {
  text += "{\"pose\":";
  AppendPose(text, SE3());
  text += ",\"points\":";
  AppendList(text, mesh.vertices, [&](const Vector3d& v) { AppendShortVector(text, v); });
  text += ",\"color\":";
  AppendColour(text, {});
  text += ",\"colors\":";
  AppendList(text, mesh.colours, [&](const std::array<std::uint8_t, 3>& c) {
    AppendColour(text, {c[0] / 255.0, c[1] / 255.0, c[2] / 255.0, 1});
  });
  text += ",\"indices\":";
  AppendList(text, mesh.faces, [&](const std::array<int, 3>& face) {
    text += std::to_string(face[0]) + ',' + std::to_string(face[1]) + ',' + std::to_string(face[2]);
  });
  text += '}';
}

Colour ColourOf(const PlaneRecord& plane) {
  constexpr std::array<Colour, 6> kColours = {{{0.9, 0.3, 0.2, 1},
                                               {0.2, 0.6, 0.9, 1},
                                               {0.3, 0.8, 0.3, 1},
                                               {0.9, 0.7, 0.1, 1},
                                               {0.7, 0.3, 0.8, 1},
                                               {0.2, 0.8, 0.7, 1}}};
  return kColours[static_cast<std::size_t>(plane.id.value) % kColours.size()];
}

void AppendOutline(std::string& text, const PlaneRecord& plane) {
  constexpr std::string_view kLineLoop = "1";
  text += "{\"type\":";
  text += kLineLoop;
  text += ",\"pose\":";
  AppendPose(text, SE3());
  text += ",\"thickness\":2,\"scale_invariant\":true,\"points\":";
  AppendList(text, plane.outline_W, [&](const Vector3d& v) { AppendShortVector(text, v); });
  text += ",\"color\":";
  AppendColour(text, ColourOf(plane));
  text += ",\"colors\":[],\"indices\":[]}";
}

void AppendLabel(std::string& text, const PlaneRecord& plane) {
  text += "{\"pose\":";
  AppendPose(text, {Quaterniond::Identity(), plane.centroid_W});
  text += ",\"billboard\":true,\"font_size\":12,\"scale_invariant\":true,\"color\":";
  AppendColour(text, ColourOf(plane));
  text += ",\"text\":";
  AppendText(text, std::string(ToString(plane.label)) + " " + std::to_string(plane.id.value));
  text += '}';
}

}  // namespace

std::string StateMessage(const VioOutput& output) {
  std::string text;
  AppendHead(text, output.t, kWorldFrame);
  text += ",\"child_frame_id\":";
  AppendText(text, kBodyFrame);
  text += ",\"status\":";
  AppendText(text, ToString(output.status));
  text += ",\"reason\":";
  AppendText(text, output.reason);
  text += output.is_keyframe ? ",\"is_keyframe\":true" : ",\"is_keyframe\":false";
  text += ",\"segment\":" + std::to_string(output.segment);
  const NavState state = output.has_pose ? output.state : NavState();
  text += ",\"position\":";
  AppendVector(text, state.T_WB.p);
  text += ",\"orientation\":";
  AppendQuaternion(text, state.T_WB.q);
  text += ",\"velocity\":";
  AppendVector(text, state.v_WB);
  text += ",\"gyro_bias\":";
  AppendVector(text, state.bias.b_g);
  text += ",\"accel_bias\":";
  AppendVector(text, state.bias.b_a);
  text += ",\"covariance\":";
  const Matrix<15, 15> covariance =
      output.has_pose ? output.causal.covariance : Matrix<15, 15>(Matrix<15, 15>::Zero());
  // Row by row: it is symmetric.
  AppendList(text, covariance.reshaped(), [&](double value) { Append(text, value); });
  text += ",\"landmarks\":" + std::to_string(output.num_landmarks);
  text += ",\"planes\":" + std::to_string(output.num_planes) + "}";
  return text;
}

std::string PoseMessage(Timestamp t, const SE3& T_WB) {
  std::string text;
  AppendHead(text, t, kWorldFrame);
  text += ",\"pose\":";
  AppendPose(text, T_WB);
  return text + "}";
}

std::string TransformMessage(Timestamp t,
                             std::string_view parent,
                             std::string_view child,
                             const SE3& T) {
  std::string text = "{\"timestamp\":";
  AppendTime(text, t);
  text += ",\"parent_frame_id\":";
  AppendText(text, parent);
  text += ",\"child_frame_id\":";
  AppendText(text, child);
  text += ",\"translation\":";
  AppendVector(text, T.p);
  text += ",\"rotation\":";
  AppendQuaternion(text, T.q);
  return text + "}";
}

std::string PathMessage(Timestamp t, std::span<const StampedPose> poses) {
  std::string text;
  AppendHead(text, t, kWorldFrame);
  text += ",\"poses\":";
  AppendList(text, poses, [&](const StampedPose& pose) { AppendPose(text, pose.T_WB); });
  return text + "}";
}

std::string MeshSceneMessage(Timestamp t, std::string_view id, const TriangleMesh& mesh) {
  std::string text;
  if (mesh.faces.empty()) {
    text += "{\"deletions\":[{\"timestamp\":";
    AppendTime(text, t);
    text += ",\"type\":0,\"id\":";
    AppendText(text, id);
    return text + "}],\"entities\":[]}";
  }
  text += "{\"deletions\":[],\"entities\":[";
  AppendEntityHead(text, t, id);
  text += ",\"lines\":[],\"texts\":[],\"triangles\":[";
  AppendTriangles(text, mesh);
  return text + "]}]}";
}

std::string PlanesSceneMessage(Timestamp t, std::span<const PlaneRecord> planes) {
  std::string text = "{\"deletions\":[{\"timestamp\":";
  AppendTime(text, t);
  text += ",\"type\":1,\"id\":\"\"}],\"entities\":";
  AppendList(text, planes, [&](const PlaneRecord& plane) {
    AppendEntityHead(text, t, "plane " + std::to_string(plane.id.value));
    text += ",\"triangles\":[],\"lines\":[";
    AppendOutline(text, plane);
    text += "],\"texts\":[";
    AppendLabel(text, plane);
    text += "]}";
  });
  return text + "}";
}

std::string ImageMessage(Timestamp t, std::string_view jpeg) {
  std::string text;
  AppendHead(text, t, kCameraFrame);
  return text + ",\"format\":\"jpeg\",\"data\":\"" + Base64(jpeg) + "\"}";
}

}  // namespace facet
