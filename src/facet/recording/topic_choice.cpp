// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/topic_choice.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "facet/io/errors.h"
#include "facet/recording/sensor_messages.h"

namespace facet {
namespace {

using Indices = std::vector<std::size_t>;

std::string LowerCase(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool Contains(const std::string& text, const std::string& part) {
  return LowerCase(text).find(part) != std::string::npos;
}

bool IsImage(const Topic& topic) {
  return topic.type == kImageType || topic.type == kCompressedImageType;
}

/// What the program can decode, of one kind.
template <class Predicate>
Indices Find(const std::vector<Topic>& topics, Predicate is_wanted) {
  Indices found;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (topics[i].encoding != MessageEncoding::kOther && is_wanted(topics[i])) found.push_back(i);
  }
  return found;
}

std::string Listing(const std::vector<Topic>& topics, const Indices& indices) {
  std::string text;
  for (const std::size_t i : indices) {
    const Topic& topic = topics[i];
    text += (text.empty() ? "" : ", ") + topic.name + " (" + topic.type;
    if (topic.num_messages > 0) text += ", " + std::to_string(topic.num_messages) + " messages";
    text += ")";
  }
  return text.empty() ? "none" : text;
}

/// The name of the raw images of a compressed topic, otherwise the name itself.
std::string BaseName(const std::string& name) {
  constexpr std::string_view kSuffix = "/compressed";
  return name.ends_with(kSuffix) ? name.substr(0, name.size() - kSuffix.size()) : name;
}

/// Images that could be of a stereo camera: no depth, and nothing twice.
Indices StereoCandidates(const std::vector<Topic>& topics) {
  return Find(topics, [&](const Topic& topic) {
    if (!IsImage(topic) || Contains(topic.name, "depth")) return false;
    if (topic.type == kImageType) return true;
    return std::ranges::none_of(topics, [&](const Topic& other) {
      return other.type == kImageType && other.name == BaseName(topic.name);
    });
  });
}

/// What stands between the common beginning and the common end of two names.
std::pair<std::string, std::string> Difference(const std::string& a, const std::string& b) {
  const std::size_t shorter = std::min(a.size(), b.size());
  std::size_t begin = 0, end = 0;
  while (begin < shorter && a[begin] == b[begin])
    ++begin;
  while (end < shorter - begin && a[a.size() - 1 - end] == b[b.size() - 1 - end])
    ++end;
  return {a.substr(begin, a.size() - begin - end), b.substr(begin, b.size() - begin - end)};
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// Whether the names differ as those of a left and a right camera do.
bool AreLeftAndRight(const std::string& left_name, const std::string& right_name) {
  const std::string left = LowerCase(left_name), right = LowerCase(right_name);
  if (left == right) return false;
  if (Replaced(right, "right", "left") == left) return true;
  const auto [a, b] = Difference(left, right);
  return (a == "l" && b == "r") || (a == "0" && b == "1") || (a == "1" && b == "2");
}

std::size_t FindNamed(const std::vector<Topic>& topics,
                      const std::string& name,
                      const Indices& candidates,
                      const std::string& role,
                      const std::string& place) {
  const auto has_name = [&](std::size_t i) {
    return topics[i].name == name || topics[i].name == "/" + name;
  };
  const auto found = std::ranges::find_if(candidates, has_name);
  if (found != candidates.end()) return *found;
  throw ConfigError("--topics " + role + "=" + name + ": " + place +
                    " has no such topic of that kind; there are: " + Listing(topics, candidates));
}

void ChooseCameras(const std::vector<Topic>& topics,
                   const TopicNames& names,
                   const std::string& place,
                   TopicChoice& choice) {
  const Indices all = Find(topics, IsImage);
  if (names.left.empty() != names.right.empty()) {
    throw ConfigError("--topics: give both left= and right=; there are: " + Listing(topics, all));
  }
  if (!names.left.empty()) {
    choice.left = FindNamed(topics, names.left, all, "left", place);
    choice.right = FindNamed(topics, names.right, all, "right", place);
    if (choice.left == choice.right) throw ConfigError("--topics: left and right are the same");
    return;
  }
  const Indices candidates = StereoCandidates(topics);
  if (candidates.size() < 2) {
    throw InputError(place + ": two topics with images (" + kImageType + ", " +
                     kCompressedImageType + ") are needed; there are: " + Listing(topics, all));
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const std::size_t left : candidates) {
    for (const std::size_t right : candidates) {
      if (topics[left].type == topics[right].type &&
          AreLeftAndRight(topics[left].name, topics[right].name)) {
        pairs.emplace_back(left, right);
      }
    }
  }
  if (pairs.size() != 1) {
    throw ConfigError(place +
                      ": which topics are the left and the right camera? Say it with "
                      "--topics left=NAME right=NAME; there are: " +
                      Listing(topics, candidates));
  }
  choice.left = pairs[0].first;
  choice.right = pairs[0].second;
}

void ChooseImu(const std::vector<Topic>& topics,
               const TopicNames& names,
               const std::string& place,
               TopicChoice& choice) {
  const Indices all = Find(topics, [](const Topic& topic) { return topic.type == kImuType; });
  if (!names.imu.empty()) {
    choice.imu = FindNamed(topics, names.imu, all, "imu", place);
    return;
  }
  if (names.gyro.empty() != names.accel.empty()) {
    throw ConfigError("--topics: give both gyro= and accel=; there are: " + Listing(topics, all));
  }
  if (!names.gyro.empty()) {
    choice.gyro = FindNamed(topics, names.gyro, all, "gyro", place);
    choice.accel = FindNamed(topics, names.accel, all, "accel", place);
    return;
  }
  if (all.empty()) {
    throw InputError(place + ": no topic of type " + kImuType + "; Facet needs an IMU");
  }
  Indices gyros, accels, others;
  for (const std::size_t i : all) {
    const bool is_gyro = Contains(topics[i].name, "gyro");
    const bool is_accel = Contains(topics[i].name, "accel");
    (is_gyro == is_accel ? others : is_gyro ? gyros : accels).push_back(i);
  }
  if (others.size() == 1 || all.size() == 1) {
    choice.imu = others.size() == 1 ? others[0] : all[0];
  } else if (others.empty() && gyros.size() == 1 && accels.size() == 1) {
    choice.gyro = gyros[0];
    choice.accel = accels[0];
  } else {
    throw ConfigError(place +
                      ": which topic is the IMU? Say it with --topics imu=NAME, or "
                      "gyro=NAME accel=NAME; there are: " +
                      Listing(topics, all));
  }
}

/// /cam/image_raw and /cam/image_raw/compressed have /cam/camera_info.
std::optional<std::size_t> FindInfo(const std::vector<Topic>& topics, const std::string& image) {
  const std::string base = BaseName(image);
  const std::size_t slash = base.rfind('/');
  const std::string name =
      (slash == std::string::npos ? "" : base.substr(0, slash + 1)) + "camera_info";
  const Indices found = Find(topics, [&](const Topic& topic) {
    return topic.type == kCameraInfoType && topic.name == name;
  });
  if (found.empty()) return std::nullopt;
  return found[0];
}

}  // namespace

TopicNames ParseTopics(const std::vector<std::string>& texts) {
  TopicNames names;
  const std::array<std::pair<const char*, std::string*>, 5> roles = {{{"left", &names.left},
                                                                      {"right", &names.right},
                                                                      {"imu", &names.imu},
                                                                      {"gyro", &names.gyro},
                                                                      {"accel", &names.accel}}};
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const std::string role = text.substr(0, equals);
    const auto found =
        std::ranges::find_if(roles, [&](const auto& known) { return role == known.first; });
    if (found == roles.end() || equals == std::string::npos || equals + 1 == text.size()) {
      throw ConfigError("--topics " + text +
                        ": left=NAME, right=NAME, imu=NAME, gyro=NAME or accel=NAME is expected "
                        "(the recording comes before --topics)");
    }
    *found->second = text.substr(equals + 1);
  }
  return names;
}

TopicChoice ChooseTopics(const std::vector<Topic>& topics,
                         const TopicNames& names,
                         const std::string& place) {
  TopicChoice choice;
  ChooseCameras(topics, names, place, choice);
  ChooseImu(topics, names, place, choice);
  choice.left_info = FindInfo(topics, topics[choice.left].name);
  choice.right_info = FindInfo(topics, topics[choice.right].name);
  return choice;
}

}  // namespace facet
