// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/saved_map_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>

#include <Eigen/Cholesky>
#include <zlib.h>

#include "facet/camera/camera_model.h"
#include "facet/io/errors.h"
#include "facet/io/text_file.h"

namespace facet {

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr std::string_view kMagic = "FACETMAP";
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kHeadSize = 8 + 4 + 8 + 4;

class Writer {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void Put(T value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }

  template <class Derived>
  void Put(const Eigen::MatrixBase<Derived>& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i)
      Put(matrix(i / matrix.cols(), i % matrix.cols()));
  }

  void Put(const UprightPose& pose) {
    Put(pose.yaw_rad);
    Put(pose.p);
  }

  void Put(const SE3& pose) {
    Put(pose.q.coeffs());
    Put(pose.p);
  }

  void PutRaw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Throws InputError where the bytes end, or a number is none.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T>
  void Get(T& value) {
    GetRaw(&value, sizeof value);
    if constexpr (std::is_floating_point_v<T>)
      Require(std::isfinite(value), "a number is not finite");
  }

  template <class Derived>
  void Get(Eigen::MatrixBase<Derived>& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i)
      Get(matrix(i / matrix.cols(), i % matrix.cols()));
  }

  void Get(UprightPose& pose) {
    Get(pose.yaw_rad);
    Get(pose.p);
  }

  void Get(SE3& pose) {
    Get(pose.q.coeffs());
    Get(pose.p);
    Require(std::abs(pose.q.norm() - 1) < 1e-6, "a rotation is none");
  }

  void GetRaw(void* data, std::size_t size) {
    Require(size <= rest_.size(), "it ends too early");
    std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }

  /// How many follow, each of at least this many bytes.
  std::size_t Count(std::size_t bytes_each) {
    std::uint64_t num = 0;
    Get(num);
    Require(num <= rest_.size() / bytes_each, "it has fewer parts than it says");
    return static_cast<std::size_t>(num);
  }

  static void Require(bool is_right, const char* wrong) {
    if (!is_right) throw InputError(wrong);
  }

  bool is_at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

// ---- each part is written and read by a pair of functions

// What is larger or smaller is an error, and could keep the optimisation from ending.
constexpr double kMostMetres = 1e7, kLeastVariance = 1e-14, kMostVariance = 1e10;

void RequirePosition(const Vector3d& p) {
  Reader::Require(p.cwiseAbs().maxCoeff() < kMostMetres, "a position is out of this world");
}

void RequireStamp(Timestamp t) {
  constexpr std::int64_t kLatest_ns = std::int64_t{1} << 62;
  Reader::Require(t.ns > -kLatest_ns && t.ns < kLatest_ns, "a stamp cannot be");
}

void Put(Writer& out, const GraphEdge& edge) {
  out.Put(std::int32_t{edge.first});
  out.Put(std::int32_t{edge.second});
  out.Put(edge.yaw_rad);
  out.Put(edge.p_first);
  out.Put(edge.covariance);
  out.Put(edge.stretch_per_px);
  out.Put(static_cast<std::uint8_t>(edge.is_closure ? 1 : 0));
  out.Put(edge.weight);
}

void Get(Reader& in, GraphEdge& edge, std::size_t num_nodes) {
  in.Get(edge.first);
  in.Get(edge.second);
  Reader::Require(edge.first >= 0 && edge.first < edge.second &&
                      static_cast<std::size_t>(edge.second) < num_nodes,
                  "an edge leads to no node");
  in.Get(edge.yaw_rad);
  in.Get(edge.p_first);
  in.Get(edge.covariance);
  RequirePosition(edge.p_first);
  Reader::Require(edge.covariance.diagonal().minCoeff() > kLeastVariance &&
                      edge.covariance.diagonal().maxCoeff() < kMostVariance &&
                      edge.covariance.isApprox(edge.covariance.transpose()) &&
                      Eigen::LLT<Matrix4d>(edge.covariance).info() == Eigen::Success,
                  "a covariance is none");
  in.Get(edge.stretch_per_px);
  Reader::Require(std::abs(edge.stretch_per_px) < 1e3, "a closure's distance cannot be");
  std::uint8_t is_closure = 0;
  in.Get(is_closure);
  edge.is_closure = is_closure != 0;
  in.Get(edge.weight);
  Reader::Require(edge.weight >= 0 && edge.weight <= 1, "a weight is none");
}

void Put(Writer& out, const GraphNode& node, const MapKeyframe& keyframe) {
  out.Put(node.p_W);
  out.Put(node.T_MW);
  out.Put(std::int32_t{node.edge_to_previous});
  out.Put(keyframe.frame.value);
  out.Put(keyframe.t.ns);
  out.Put(std::int32_t{keyframe.segment});
  out.Put(std::int32_t{keyframe.session});
}

void Get(Reader& in, GraphNode& node, MapKeyframe& keyframe) {
  in.Get(node.p_W);
  in.Get(node.T_MW);
  in.Get(node.edge_to_previous);
  in.Get(keyframe.frame.value);
  in.Get(keyframe.t.ns);
  in.Get(keyframe.segment);
  in.Get(keyframe.session);
  RequirePosition(node.p_W);
  RequirePosition(node.T_MW.p);
  RequireStamp(keyframe.t);
}

void Put(Writer& out, const CameraIntrinsics& lens) {
  out.Put(std::int32_t{lens.width});
  out.Put(std::int32_t{lens.height});
  for (const double value : {lens.fx, lens.fy, lens.cx, lens.cy})
    out.Put(value);
  out.Put(static_cast<std::uint8_t>(lens.distortion));
  for (const double coefficient : lens.coefficients)
    out.Put(coefficient);
}

void Get(Reader& in, CameraIntrinsics& lens) {
  in.Get(lens.width);
  in.Get(lens.height);
  for (double* value : {&lens.fx, &lens.fy, &lens.cx, &lens.cy})
    in.Get(*value);
  std::uint8_t model = 0;
  in.Get(model);
  Reader::Require(model <= static_cast<std::uint8_t>(DistortionModel::kUnified),
                  "a lens is of no model");
  lens.distortion = static_cast<DistortionModel>(model);
  for (double& coefficient : lens.coefficients)
    in.Get(coefficient);
  Reader::Require(CameraModel::WhatIsWrong(lens).empty(), "a lens cannot be");
}

constexpr std::size_t kPointBytes =
    6 * 4 + 2 * (RecordPatch::kSide * RecordPatch::kSide + 8) + kNumCornerLevels * 32;

void Put(Writer& out, const RecordPoint& point) {
  out.Put(point.p_C);
  out.Put(point.px);
  out.Put(point.sigma_depth_m);
  for (const RecordPatch& patch : point.patches) {
    out.PutRaw(patch.grey.data(), patch.grey.size());
    out.Put(patch.x);
    out.Put(patch.y);
  }
  for (const BinaryDescriptor& descriptor : point.descriptors)
    out.PutRaw(descriptor.data(), sizeof descriptor);
}

void Get(Reader& in, RecordPoint& point) {
  in.Get(point.p_C);
  in.Get(point.px);
  in.Get(point.sigma_depth_m);
  Reader::Require(point.p_C.norm() > 0 && point.sigma_depth_m >= 0, "a point is nowhere");
  for (RecordPatch& patch : point.patches) {
    in.GetRaw(patch.grey.data(), patch.grey.size());
    in.Get(patch.x);
    in.Get(patch.y);
    constexpr float kSide = RecordPatch::kSide;
    Reader::Require(patch.x >= 0 && patch.x < kSide && patch.y >= 0 && patch.y < kSide,
                    "a patch is not around its point");
  }
  for (BinaryDescriptor& descriptor : point.descriptors)
    in.GetRaw(descriptor.data(), sizeof descriptor);
}

void Put(Writer& out, const PlaceRecord& place) {
  out.Put(std::int32_t{place.node});
  out.Put(place.t.ns);
  out.Put(std::int32_t{place.segment});
  out.Put(std::int32_t{place.session});
  out.Put(place.frame.value);
  out.Put(place.T_WB);
  out.Put(place.T_BC);
  out.Put(place.sigma_tilt_rad);
  out.Put(place.median_distance_m);
  out.Put(std::uint64_t{place.points.size()});
  for (const RecordPoint& point : place.points)
    Put(out, point);
}

void Get(Reader& in, PlaceRecord& place, const SavedMap& map) {
  in.Get(place.node);
  in.Get(place.t.ns);
  in.Get(place.segment);
  in.Get(place.session);
  in.Get(place.frame.value);
  Reader::Require(place.node >= 0 && static_cast<std::size_t>(place.node) < map.graph.nodes.size(),
                  "a place is at no node");
  const MapKeyframe& keyframe = map.keyframes[static_cast<std::size_t>(place.node)];
  Reader::Require(place.session == keyframe.session && place.t == keyframe.t,
                  "a place is not of its node");
  in.Get(place.T_WB);
  in.Get(place.T_BC);
  RequirePosition(place.T_WB.p);
  RequirePosition(place.T_BC.p);
  in.Get(place.sigma_tilt_rad);
  in.Get(place.median_distance_m);
  Reader::Require(place.sigma_tilt_rad > 0 && place.median_distance_m > 0, "a place has no size");
  place.points.resize(in.Count(kPointBytes));
  for (RecordPoint& point : place.points)
    Get(in, point);
}

std::string Pack(const SavedMap& map) {
  Writer out;
  out.Put(std::uint64_t{map.lenses.size()});
  for (const CameraIntrinsics& lens : map.lenses)
    Put(out, lens);
  out.Put(map.graph.disparity_error_px);
  out.Put(std::uint64_t{map.keyframes.size()});
  for (std::size_t i = 0; i < map.keyframes.size(); ++i)
    Put(out, map.graph.nodes[i], map.keyframes[i]);
  out.Put(std::uint64_t{map.graph.edges.size()});
  for (const GraphEdge& edge : map.graph.edges)
    Put(out, edge);
  out.Put(std::uint64_t{map.places.size()});
  for (const PlaceRecord& place : map.places)
    Put(out, place);
  return out.bytes();
}

/// Runs follow each other, and neighbours in them are joined by edges.
void CheckNodes(const SavedMap& map) {
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const int session = map.keyframes[i].session;
    const int before = i == 0 ? 0 : map.keyframes[i - 1].session;
    Reader::Require(session >= before && session < map.num_sessions(), "a node is of no run");
    const int edge = map.graph.nodes[i].edge_to_previous;
    const bool is_first = i == 0;
    Reader::Require(is_first == (edge < 0) && edge < static_cast<int>(map.graph.edges.size()),
                    "a node has no edge");
    if (is_first) continue;
    const GraphEdge& to_previous = map.graph.edges[static_cast<std::size_t>(edge)];
    Reader::Require(!to_previous.is_closure && to_previous.second == static_cast<int>(i) &&
                        to_previous.first == to_previous.second - 1,
                    "a node has no edge");
  }
}

SavedMap Unpack(std::string_view bytes) {
  constexpr std::size_t kNodeBytes = 7 * 8 + 4 + 16 + 8, kEdgeBytes = 8 + 22 * 8 + 1;
  constexpr std::size_t kLensBytes = 8 + 4 * 8 + 1 + 8 * kMaxLensCoefficients;
  constexpr std::size_t kMostSessions = 1'000'000;
  constexpr std::size_t kPlaceBytes = 3 * 4 + 16 + 14 * 8 + 16 + 8;
  Reader in(bytes);
  SavedMap map;
  map.lenses.resize(in.Count(kLensBytes));
  Reader::Require(!map.lenses.empty() && map.lenses.size() < kMostSessions, "it has no runs");
  for (CameraIntrinsics& lens : map.lenses)
    Get(in, lens);
  in.Get(map.graph.disparity_error_px);
  map.keyframes.resize(in.Count(kNodeBytes));
  map.graph.nodes.resize(map.keyframes.size());
  for (std::size_t i = 0; i < map.keyframes.size(); ++i)
    Get(in, map.graph.nodes[i], map.keyframes[i]);
  map.graph.edges.resize(in.Count(kEdgeBytes));
  for (GraphEdge& edge : map.graph.edges)
    Get(in, edge, map.graph.nodes.size());
  CheckNodes(map);
  map.places.resize(in.Count(kPlaceBytes));
  for (PlaceRecord& place : map.places)
    Get(in, place, map);
  Reader::Require(in.is_at_end(), "something is behind its end");
  Reader::Require(!map.places.empty(), "it has no places");
  Reader::Require(std::is_sorted(map.places.begin(),
                                 map.places.end(),
                                 [](const auto& a, const auto& b) { return a.node < b.node; }),
                  "places are in no order");
  return map;
}

std::uint32_t Crc(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string_view Payload(std::string_view file) {
  Reader::Require(file.size() >= kHeadSize && file.substr(0, kMagic.size()) == kMagic,
                  "it is no map of Facet");
  Reader head(file.substr(kMagic.size()));
  std::uint32_t version = 0, crc = 0;
  std::uint64_t size = 0;
  head.Get(version);
  head.Get(size);
  head.Get(crc);
  if (version != kVersion)
    throw InputError("it is of version " + std::to_string(version) + ", and this program reads " +
                     std::to_string(kVersion) + "; make it anew");
  const std::string_view payload = file.substr(kHeadSize);
  Reader::Require(payload.size() == size, "it is not as long as it says: was its copy cut off?");
  Reader::Require(Crc(payload) == crc, "its checksum is another: it is damaged");
  return payload;
}

}  // namespace

void WriteSavedMap(const std::filesystem::path& folder, const SavedMap& map) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw OutputError(folder.string() + ": " + error.message());
  const std::string payload = Pack(map);
  Writer head;
  head.PutRaw(kMagic.data(), kMagic.size());
  head.Put(kVersion);
  head.Put(std::uint64_t{payload.size()});
  head.Put(Crc(payload));
  ReplaceTextFile(folder / kSavedMapName, head.bytes() + payload);
}

SavedMap ReadSavedMap(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kSavedMapName;
  // A pipe or a device could be read for ever.
  std::error_code unreadable;
  if (!std::filesystem::is_regular_file(file, unreadable))
    throw InputError(file.string() + ": no map of places; facet run --save-map makes one");
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  if (stream.bad() || !stream.is_open()) throw InputError(file.string() + ": cannot be read");
  try {
    return Unpack(Payload(bytes));
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

}  // namespace facet
