// SPDX-License-Identifier: BSD-2-Clause
// What the page is to show: the newest message of each slot. A client that is slow, or comes late,
// gets the newest ones and never those in between, so no queue grows whatever clients do.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace facet {

/// Bytes that several clients may be sent at the same time.
using SharedBytes = std::shared_ptr<const std::string>;

/// Thread-safe; a lock is held for the look-up of a slot, never while something is sent.
class ViewBoard {
 public:
  struct Entry {
    std::uint64_t number = 0;  ///< of the posting; counts from 1
    SharedBytes message;
  };

  /// Replaces what the slot held. It goes to the end of the order in which slots are sent.
  void Post(const std::string& slot, std::string message);

  /// The same for what has to come before everything else: all other messages are posted anew
  /// behind it, in their order.
  void PostFirst(const std::string& slot, std::string message);

  /// Empties the slot; clients that already have its message keep it.
  void Remove(const std::string& slot);

  /// The oldest posting after `number` that is still on the board: what a client that has seen the
  /// postings up to `number` is sent next.
  std::optional<Entry> NextAfter(std::uint64_t number) const;

  std::size_t num_slots() const;
  std::size_t num_bytes() const;  ///< of all messages on the board

 private:
  // Under the lock.
  void Put(const std::string& slot, SharedBytes message);
  void Erase(const std::string& slot);

  mutable std::mutex mutex_;
  std::uint64_t newest_ = 0;
  std::size_t num_bytes_ = 0;
  std::map<std::string, std::uint64_t> number_of_slot_;
  std::map<std::uint64_t, SharedBytes> messages_;  // by number
};

}  // namespace facet
