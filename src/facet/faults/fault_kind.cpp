// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/fault_kind.h"

namespace facet {

FaultSpan SpanOf(const FaultValues& value, const RecordingCopy& recording) {
  const Timestamp begin = recording.images[0].front().t + FromSeconds(value.at("at"));
  return {begin, begin + FromSeconds(value.at("length"))};
}

std::vector<std::size_t> CamerasOf(const FaultValues& value) {
  if (value.at("camera") >= 2) return {0, 1};
  return {value.at("camera") < 1 ? std::size_t{0} : std::size_t{1}};
}

}  // namespace facet
