// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/frame_records.h"

#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/states_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// The fields of a line; a field in quotes may hold commas.
std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (char c : line) {
    if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

/// A table whose first line names the columns.
class NamedTable {
 public:
  explicit NamedTable(const fs::path& file) : file_(file) {
    std::error_code error;
    if (fs::exists(file, error) && !fs::is_regular_file(file, error))
      throw InputError(file.string() + ": is no file");  // nobody may ever write to a pipe
    stream_.open(file);
    std::string header;
    std::getline(stream_, header);
    const std::vector<std::string> names = Fields(header);
    for (std::size_t i = 0; i < names.size(); ++i)
      columns_.emplace(names[i], i);
  }

  bool Next() {
    std::string line;
    ++line_;
    if (!std::getline(stream_, line)) return false;
    fields_ = Fields(line);
    return true;
  }

  std::string Text(const std::string& name) const {
    const auto column = columns_.find(name);
    if (column == columns_.end() || column->second >= fields_.size()) return "";
    return fields_[column->second];
  }
  double Number(const std::string& name) const {
    return ParseDouble(Text(name)).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  int Count(const std::string& name) const {
    return static_cast<int>(ParseInteger(Text(name)).value_or(0));
  }
  Timestamp Stamp() const {
    const auto ns = ParseInteger(Text("timestamp_ns"));
    if (!ns) {
      throw InputError(file_.string() + ":" + std::to_string(line_ + 1) +
                       ": the column timestamp_ns holds no integer");
    }
    return {*ns};
  }

 private:
  fs::path file_;
  std::ifstream stream_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> fields_;
  int line_ = 0;
};

/// A frame of which nothing is known but its stamp.
FrameRecord Frame(Timestamp t) {
  FrameRecord f;
  f.t = f.state.t = t;
  const Vector3d unknown = Unknown3();
  f.state.T_WB.p = f.state.v_WB = f.state.bias.b_g = f.state.bias.b_a = unknown;
  f.sigma_p = f.sigma_theta = f.sigma_v = f.sigma_b_g = f.sigma_b_a = unknown;
  return f;
}

void TakeState(const EstimatedState& s, FrameRecord& f) {
  f.has_pose = true;
  f.state = s.state;
  f.segment = s.segment;
  f.sigma_p = s.sigma_p;
  f.sigma_theta = s.sigma_theta;
  f.sigma_v = s.sigma_v;
  f.sigma_b_g = s.sigma_b_g;
  f.sigma_b_a = s.sigma_b_a;
}

// ReadStates judges what it reads, and leaves out frames without a pose.
std::vector<FrameRecord> FromStates(const fs::path& file) {
  const std::vector<EstimatedState> states = ReadStates(file);
  auto state = states.begin();
  std::vector<FrameRecord> frames;
  NamedTable row(file);
  while (row.Next()) {
    FrameRecord& f = frames.emplace_back(Frame(row.Stamp()));
    f.status = row.Text("status");
    f.reason = row.Text("reason");
    f.segment = row.Count("segment");
    if (state != states.end() && state->state.t == f.t) TakeState(*state++, f);
  }
  return frames;
}

void AddTiming(const fs::path& file, std::vector<FrameRecord>& frames) {
  std::unordered_map<std::int64_t, FrameRecord*> by_stamp;
  for (FrameRecord& f : frames)
    by_stamp.emplace(f.t.ns, &f);
  NamedTable row(file);
  while (row.Next()) {
    const auto found = by_stamp.find(row.Stamp().ns);
    if (found == by_stamp.end()) continue;
    FrameRecord& f = *found->second;
    f.is_keyframe = row.Count("is_keyframe") != 0;
    for (std::size_t i = 0; i < kNumStages; ++i)
      f.times.ms[i] = row.Number(kStageNames[i]);
    f.wall_ms = row.Number("wall_ms");
    f.latency_ms = row.Number("latency_ms");
    f.num_landmarks = row.Count("landmarks");
    f.num_planes = row.Count("planes");
    f.num_constraints = row.Count("constraints");
  }
}

std::vector<FrameRecord> FromTrajectory(const fs::path& file) {
  std::vector<FrameRecord> frames;
  for (const StampedPose& pose : ReadTrajectory(file).poses) {
    FrameRecord& f = frames.emplace_back(Frame(pose.t));
    f.has_pose = true;
    f.state.T_WB = pose.T_WB;
    f.status = "ok";
  }
  return frames;
}

}  // namespace

std::vector<FrameRecord> ReadFrameRecords(const fs::path& folder) {
  if (!fs::exists(folder / "states.csv")) return FromTrajectory(folder / "trajectory.tum");
  std::vector<FrameRecord> frames = FromStates(folder / "states.csv");
  AddTiming(folder / "timing.csv", frames);
  return frames;
}

}  // namespace facet
