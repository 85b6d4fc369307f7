// SPDX-License-Identifier: BSD-2-Clause
// FACET_CHECK(cond) << "text": for programmer errors only, never for data. Throws CheckError.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace facet {

class CheckError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace internal {

class CheckMessage {
 public:
  CheckMessage(const char* condition, const char* file, int line) {
    text_ << file << ':' << line << ": check failed: " << condition << ' ';
  }
  CheckMessage(const CheckMessage&) = delete;
  CheckMessage& operator=(const CheckMessage&) = delete;
  ~CheckMessage() noexcept(false) { throw CheckError(text_.str()); }

  template <class T>
  CheckMessage& operator<<(const T& value) {
    text_ << value;
    return *this;
  }

 private:
  std::ostringstream text_;
};

}  // namespace internal
}  // namespace facet

#define FACET_CHECK(condition) \
  if (condition) {             \
  } else                       \
    ::facet::internal::CheckMessage(#condition, __FILE__, __LINE__)
