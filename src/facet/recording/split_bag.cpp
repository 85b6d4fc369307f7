// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/split_bag.h"

#include <algorithm>
#include <utility>

#include "facet/base/check.h"

namespace facet {

SplitBag::SplitBag(std::vector<std::filesystem::path> files, Opener opener)
    : files_(std::move(files)), opener_(std::move(opener)) {
  FACET_CHECK(!files_.empty()) << "no file";
  Duration sum;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    Open(i);
    for (std::size_t k = 0; k < topic_of_source_.size(); ++k)
      topics_[topic_of_source_[k]].num_messages += source_->topics()[k].num_messages;
    if (source_->IndexedDuration()) sum = sum + *source_->IndexedDuration();
    const std::vector<std::string> more = source_->Warnings();
    warnings_.insert(warnings_.end(), more.begin(), more.end());
  }
  if (sum.ns > 0) duration_ = sum;
  Rewind();
}

std::string SplitBag::Kind() const {
  if (files_.size() == 1) return source_->Kind();
  return source_->Kind() + ", " + std::to_string(files_.size()) + " files";
}

void SplitBag::Open(std::size_t file) {
  file_ = file;
  source_ = opener_(files_[file]);
  topic_of_source_.clear();
  for (const Topic& topic : source_->topics()) {
    const auto same = std::ranges::find_if(topics_, [&](const Topic& known) {
      return known.name == topic.name && known.type == topic.type &&
             known.encoding == topic.encoding;
    });
    topic_of_source_.push_back(static_cast<std::size_t>(same - topics_.begin()));
    if (same != topics_.end()) continue;
    topics_.push_back(topic);
    topics_.back().num_messages = 0;
  }
}

void SplitBag::Rewind() {
  if (file_ != 0) Open(0);
  source_->Rewind();
}

std::optional<Message> SplitBag::Next() {
  while (true) {
    if (auto message = source_->Next()) {
      if (message->topic >= topic_of_source_.size()) continue;  // its index does not know the topic
      message->topic = topic_of_source_[message->topic];
      return message;
    }
    if (file_ + 1 == files_.size()) return std::nullopt;
    Open(file_ + 1);
  }
}

}  // namespace facet
