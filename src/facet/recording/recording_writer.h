// SPDX-License-Identifier: BSD-2-Clause
// Takes a recording event by event and writes it in a layout of its own.
#pragma once

#include "facet/recording/recording.h"

namespace facet {

/// Not thread-safe. All functions throw OutputError when something cannot be written.
class RecordingWriter {
 public:
  RecordingWriter() = default;
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;
  virtual ~RecordingWriter() = default;

  virtual void Add(const ImuSample& sample) = 0;

  /// Images become 8-bit grey; one that cannot be decoded is left out and counted.
  virtual void Add(const RecordedFrame& frame) = 0;

  /// Makes what was written a complete recording.
  virtual void Commit() = 0;

  int num_kept() const { return num_kept_; }          ///< images that were there already
  int num_unusable() const { return num_unusable_; }  ///< images

 protected:
  int num_kept_ = 0, num_unusable_ = 0;
};

}  // namespace facet
