// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/open_recording.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/io/kitti_raw.h"
#include "facet/io/plain_folder.h"
#include "facet/io/yaml_file.h"
#include "facet/recording/bag_recording.h"
#include "facet/recording/db3_file.h"
#include "facet/recording/decompressed_messages.h"
#include "facet/recording/folder_recording.h"
#include "facet/recording/mcap_file.h"
#include "facet/recording/ros1_bag.h"
#include "facet/recording/split_bag.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using std::string_view_literals::operator""sv;

constexpr const char* kExpected =
    "a folder with mav0/ (ASL, EuRoC, TUM-VI), with image_00/ and oxts/ (KITTI), or with left/, "
    "right/ and imu.csv, a ROS 1 bag, an MCAP file or a ROS 2 bag (.db3, or folder) is expected";

enum class BagKind { kNone, kRos1, kMcap, kDb3 };

BagKind KindOfFile(const fs::path& file) {
  // A pipe would wait for somebody to write into it.
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return BagKind::kNone;
  std::array<char, 16> begin{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), begin.size());
  const std::string_view text(begin.data(), static_cast<std::size_t>(stream.gcount()));
  if (text.starts_with("#ROSBAG V"sv)) return BagKind::kRos1;
  if (text.starts_with("\x89MCAP"sv)) return BagKind::kMcap;
  return text.starts_with("SQLite format 3\0"sv) ? BagKind::kDb3 : BagKind::kNone;
}

bool HasBagName(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".bag" || extension == ".mcap" || extension == ".db3";
}

[[noreturn]] void FailUnknown(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    throw InputError(file.string() + ": neither a file nor a folder; " + kExpected);
  }
  if (fs::file_size(file, error) == 0) {
    throw InputError(file.string() + ": the file is empty; copy it again");
  }
  const std::string extension = file.extension().string();
  if (extension == ".zstd" || extension == ".zst") {
    throw InputError(file.string() +
                     ": the file is compressed as a whole; decompress it first: zstd -d --rm " +
                     file.filename().string());
  }
  const char* what =
      HasBagName(file) ? "damaged, or not what its name says; " : "unknown kind of file; ";
  throw InputError(file.string() + ": at byte 0: " + what + kExpected);
}

std::unique_ptr<MessageSource> OpenFile(const fs::path& file) {
  switch (KindOfFile(file)) {
    case BagKind::kRos1:
      return std::make_unique<Ros1Bag>(file);
    case BagKind::kMcap:
      return std::make_unique<DecompressedMessages>(std::make_unique<McapFile>(file));
    case BagKind::kDb3:
      return std::make_unique<DecompressedMessages>(std::make_unique<Db3File>(file));
    default:
      FailUnknown(file);
  }
}

/// x_2.bag before x_10.bag.
bool NaturalOrder(const fs::path& a, const fs::path& b) {
  const std::string x = a.filename().string(), y = b.filename().string();
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t i = 0, k = 0; i < x.size() && k < y.size();) {
    if (!is_digit(x[i]) || !is_digit(y[k])) {
      if (x[i] != y[k]) return x[i] < y[k];
      ++i, ++k;
      continue;
    }
    const auto number = [&](const std::string& text, std::size_t& at) {
      const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
      for (at = std::max(at, begin); at < text.size() && is_digit(text[at]);)
        ++at;
      return text.substr(begin, at - std::min(at, begin));
    };
    const std::string m = number(x, i), n = number(y, k);
    if (m.size() != n.size()) return m.size() < n.size();
    if (m != n) return m < n;
  }
  return x.size() != y.size() ? x.size() < y.size() : x < y;
}

/// relative_file_paths of metadata.yaml; empty if they cannot be read.
std::vector<fs::path> FilesOfMetadata(const fs::path& folder) {
  const YamlFile yaml(folder / "metadata.yaml");
  const YAML::Node bag = yaml.Require(yaml.root(), "rosbag2_bagfile_information");
  const YAML::Node mode = bag["compression_mode"], format = bag["compression_format"];
  const bool is_compressed = mode && mode.IsScalar() && mode.Scalar() == "MESSAGE";
  if (is_compressed && format && format.IsScalar() && format.Scalar() != "zstd") {
    yaml.Fail(format,
              "messages are compressed with '" + format.Scalar() +
                  "', zstd is known; convert the bag with `ros2 bag convert`");
  }
  const YAML::Node paths = yaml.Require(bag, "relative_file_paths");
  std::vector<fs::path> files;
  if (!paths.IsSequence()) yaml.Fail(paths, "'relative_file_paths' must be a list");
  for (const YAML::Node& path : paths) {
    if (!path.IsScalar()) yaml.Fail(path, "a file name is expected");
    fs::path file = folder / path.Scalar();
    std::error_code error;
    // Old recorders wrote the folder's name, too.
    if (!fs::exists(file, error)) file = folder / file.filename();
    files.push_back(file);
  }
  if (files.empty()) yaml.Fail(paths, "'relative_file_paths' is empty");
  return files;
}

std::vector<fs::path> FilesOfFolder(const fs::path& folder) {
  std::error_code error;
  if (fs::is_regular_file(folder / "metadata.yaml", error)) return FilesOfMetadata(folder);
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && HasBagName(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files, NaturalOrder);
  return files;
}

bool IsAsl(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "mav0", error) || fs::is_directory(folder / "cam0", error);
}

bool HasNames(const TopicNames& names) {
  return !names.left.empty() || !names.right.empty() || !names.imu.empty() || !names.gyro.empty() ||
         !names.accel.empty();
}

std::unique_ptr<Recording> MakeFolderRecording(RecordingFiles files) {
  return std::make_unique<FolderRecording>(StereoDataset(std::move(files)));
}

}  // namespace

FolderKind KindOfFolder(const fs::path& path) {
  if (IsAsl(path)) return FolderKind::kAsl;
  if (IsKittiRaw(path)) return FolderKind::kKitti;
  return IsPlainFolder(path) ? FolderKind::kPlain : FolderKind::kOther;
}

std::unique_ptr<MessageSource> OpenMessages(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(path.string() + ": no such folder or file");
  std::unique_ptr<MessageSource> source;
  if (!fs::is_directory(path, error)) {
    source = OpenFile(path);
  } else {
    if (KindOfFolder(path) != FolderKind::kOther) return nullptr;
    std::vector<fs::path> files = FilesOfFolder(path);
    if (files.empty()) return nullptr;
    source = std::make_unique<SplitBag>(std::move(files), OpenFile);
  }
  if (source->topics().empty()) {
    throw InputError(path.string() +
                     ": there is no message in it; was the recorder stopped at once?");
  }
  return source;
}

std::unique_ptr<Recording> OpenRecording(const fs::path& path, const RecordingOptions& options) {
  if (std::unique_ptr<MessageSource> messages = OpenMessages(path)) {
    return std::make_unique<BagRecording>(
        std::move(messages),
        path,
        BagOptions{options.calibration, options.topics, options.needs_calibration});
  }
  if (HasNames(options.topics)) {
    throw ConfigError("--topics: " + path.string() + " is no bag, it has no topics");
  }
  switch (KindOfFolder(path)) {
    case FolderKind::kAsl:
      return MakeFolderRecording(ReadAslFolder(path, options.calibration));
    case FolderKind::kKitti:
      return MakeFolderRecording(ReadKittiRaw(path, options.calibration));
    case FolderKind::kPlain:
      return MakeFolderRecording(ReadPlainFolder(path, options.calibration));
    case FolderKind::kOther:
      break;
  }
  throw InputError(path.string() + ": holds neither mav0/ nor cam0/ nor bags; " + kExpected);
}

}  // namespace facet
