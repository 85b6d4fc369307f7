// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_board.h"

#include <utility>

namespace facet {

void ViewBoard::Post(const std::string& slot, std::string message) {
  auto shared = std::make_shared<const std::string>(std::move(message));
  const std::lock_guard lock(mutex_);
  Put(slot, std::move(shared));
}

void ViewBoard::PostFirst(const std::string& slot, std::string message) {
  auto shared = std::make_shared<const std::string>(std::move(message));
  const std::lock_guard lock(mutex_);
  Put(slot, std::move(shared));
  const std::uint64_t first = newest_;
  std::map<std::uint64_t, std::string> others;
  for (const auto& [name, number] : number_of_slot_) {
    if (number != first) others.emplace(number, name);
  }
  for (const auto& [number, name] : others) {
    auto node = messages_.extract(number);
    messages_.emplace(++newest_, std::move(node.mapped()));
    number_of_slot_[name] = newest_;
  }
}

void ViewBoard::Put(const std::string& slot, SharedBytes message) {
  Erase(slot);
  num_bytes_ += message->size();
  number_of_slot_[slot] = ++newest_;
  messages_.emplace(newest_, std::move(message));
}

void ViewBoard::Remove(const std::string& slot) {
  const std::lock_guard lock(mutex_);
  Erase(slot);
}

void ViewBoard::Erase(const std::string& slot) {
  const auto number = number_of_slot_.find(slot);
  if (number == number_of_slot_.end()) return;
  const auto message = messages_.find(number->second);
  num_bytes_ -= message->second->size();
  messages_.erase(message);
  number_of_slot_.erase(number);
}

std::optional<ViewBoard::Entry> ViewBoard::NextAfter(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  const auto next = messages_.upper_bound(number);
  if (next == messages_.end()) return std::nullopt;
  return Entry{next->first, next->second};
}

std::size_t ViewBoard::num_slots() const {
  const std::lock_guard lock(mutex_);
  return messages_.size();
}

std::size_t ViewBoard::num_bytes() const {
  const std::lock_guard lock(mutex_);
  return num_bytes_;
}

}  // namespace facet
