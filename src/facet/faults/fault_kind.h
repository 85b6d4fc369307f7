// SPDX-License-Identifier: BSD-2-Clause
// One kind of fault, and what planting one needs: parts of the time, choices of cameras.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "facet/faults/recording_copy.h"

namespace facet {

/// Parameters of a fault by their names.
using FaultValues = std::map<std::string, double>;

struct FaultKind {
  std::string name;
  FaultValues defaults;
  std::string meaning;
  void (*plant)(const FaultValues& value, RecordingCopy& recording);
};

/// Each list in the order in which it is printed.
std::vector<FaultKind> StampFaults();
std::vector<FaultKind> ImuFaults();
std::vector<FaultKind> ImageFaults();
std::vector<FaultKind> RigFaults();

/// Begin included, end not.
struct FaultSpan {
  Timestamp begin, end;
  bool Has(Timestamp t) const { return t >= begin && t < end; }
};

/// From value("at") seconds after the first image on, for value("length") seconds.
FaultSpan SpanOf(const FaultValues& value, const RecordingCopy& recording);

/// The cameras that value("camera") names: 0 left, 1 right, 2 both.
std::vector<std::size_t> CamerasOf(const FaultValues& value);

template <class Item>
void Erase(std::vector<Item>& items, const FaultSpan& span) {
  std::erase_if(items, [&](const Item& item) { return span.Has(item.t); });
}

/// Gives the images of the span an edit.
template <class MakeEdit>
void EditImages(const FaultValues& value, RecordingCopy& recording, const MakeEdit& make_edit) {
  const FaultSpan span = SpanOf(value, recording);
  for (const std::size_t camera : CamerasOf(value)) {
    for (RecordedImage& image : recording.images[camera]) {
      if (span.Has(image.t)) image.edits.push_back(make_edit(image, camera));
    }
  }
}

}  // namespace facet
