// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/split_bag.h"

#include <utility>

#include "facet/base/check.h"
#include "facet/io/errors.h"

namespace facet {

SplitBag::SplitBag(std::vector<std::filesystem::path> files, Opener opener)
    : files_(std::move(files)), opener_(std::move(opener)) {
  FACET_CHECK(!files_.empty()) << "no file";
  Duration sum;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    try {
      Open(i);
    } catch (const InputError& error) {
      if (i == 0) throw;
      damage_ = error.what();
      files_.resize(i);
      break;
    }
    for (std::size_t k = 0; k < topic_of_source_.size(); ++k)
      topics_[topic_of_source_[k]].num_messages += source_->topics()[k].num_messages;
    if (source_->IndexedDuration()) sum = sum + *source_->IndexedDuration();
    const std::vector<std::string> more = source_->Warnings();
    warnings_.insert(warnings_.end(), more.begin(), more.end());
  }
  if (sum.ns > 0) duration_ = sum;
  Open(0);
}

std::string SplitBag::Kind() const {
  if (files_.size() == 1) return source_->Kind();
  return source_->Kind() + ", " + std::to_string(files_.size()) + " files";
}

void SplitBag::Open(std::size_t file) {
  source_ = opener_(files_[file]);
  file_ = file;
  topic_of_source_.clear();
  for (const Topic& topic : source_->topics())
    topic_of_source_.push_back(FindOrAddTopic(topics_, topic));
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
    if (file_ + 1 == files_.size()) {
      if (!damage_.empty()) throw InputError(damage_);
      return std::nullopt;
    }
    Open(file_ + 1);
  }
}

}  // namespace facet
