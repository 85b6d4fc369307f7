// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/recording/recording_fuzz.h"

#include <algorithm>

#include "facet/io/errors.h"
#include "facet/recording/open_recording.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

TestSequenceOptions SmallSequence() {
  TestSequenceOptions options;
  options.num_frames = 4;
  options.width = 24;
  options.height = 18;
  options.imu_interval_ns = 20000000;
  return options;
}

std::vector<TestMessage> SmallMessages(const std::filesystem::path& sequence,
                                       MessageEncoding encoding) {
  std::vector<TestMessage> messages = CalibrationMessagesOfSequence(sequence, encoding);
  std::ranges::copy(MessagesOfSequence(sequence, encoding), std::back_inserter(messages));
  return messages;
}

/// The same with PNG instead of raw images.
std::vector<TestMessage> WithCompressedImages(std::vector<TestMessage> messages) {
  const TestSequenceOptions options = SmallSequence();
  TestImage grey{options.width, options.height, 1, {}};
  grey.samples.resize(static_cast<std::size_t>(options.width * options.height), 90);
  for (TestMessage& message : messages) {
    if (message.type != kImageType) continue;
    message.type = kCompressedImageType;
    message.topic += "/compressed";
    message.bytes = CompressedImageBytes(MessageEncoding::kCdr, message.received, EncodePng(grey));
  }
  return messages;
}

}  // namespace

std::vector<std::string> RecordingSeeds() {
  const TempFolder folder;
  WriteTestSequence(folder / "seq", SmallSequence());
  const auto ros1 = SmallMessages(folder / "seq", MessageEncoding::kRos1);
  const auto cdr = SmallMessages(folder / "seq", MessageEncoding::kCdr);
  WriteDb3(folder / "a.db3", cdr);
  std::vector<TestMessage> compressed = cdr;
  for (TestMessage& message : compressed)
    message.bytes = Compressed(Compression::kZstd, message.bytes);
  return {Ros1BagBytes(ros1),
          Ros1BagBytes(ros1, {.compression = Compression::kLz4}),
          Ros1BagBytes(ros1, {.compression = Compression::kBz2}),
          Ros1BagBytes(ros1, {.messages_per_chunk = 0, .has_index = false}),
          McapBytes(cdr),
          McapBytes(cdr, {.compression = Compression::kLz4}),
          McapBytes(cdr, {.compression = Compression::kZstd}),
          McapBytes(cdr, {.messages_per_chunk = 0, .has_index = false}),
          McapBytes(WithCompressedImages(cdr), {.compression = Compression::kZstd}),
          McapBytes(compressed),
          ReadText(folder / "a.db3")};
}

bool ReadsRecordingOrComplains(const std::filesystem::path& folder, const std::string& content) {
  WriteText(folder / "recording", content);
  try {
    const std::unique_ptr<Recording> recording = OpenRecording(folder / "recording");
    ImageReader reader;
    cv::Mat grey;
    while (const auto event = recording->Next()) {
      const auto* frame = std::get_if<RecordedFrame>(&*event);
      if (frame == nullptr) continue;
      frame->left->Decode({}, reader, grey);
      if (frame->HasRight()) frame->right->Decode({}, reader, grey);
    }
    return true;
  } catch (const InputError&) {
    return false;
  } catch (const ConfigError&) {
    return false;
  }
}

}  // namespace facet
