// SPDX-License-Identifier: BSD-2-Clause
// Who may see the page: the rules by which the viewer answers or refuses a request.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace facet {

/// What decides about a request. A field that the request does not have is empty.
struct ViewRequest {
  std::string_view host;                   ///< header Host
  std::optional<std::string_view> origin;  ///< header Origin
  std::string_view target;                 ///< path and query as the client wrote them
};

/// A target, taken apart. Nothing is decoded: no name that the viewer knows needs it.
struct ViewTarget {
  std::string_view path, token;
};
ViewTarget ParseTarget(std::string_view target);

/// Host and token of the server. A page of another site must not reach it through a name of its own
/// that resolves to this machine (DNS rebinding), nor open a socket to it; who is not on this
/// machine needs the token.
class ViewAccess {
 public:
  /// `host`: address or name that the server is bound to. `token`: empty where none is needed.
  ViewAccess(std::string host, std::string token);

  /// Why the request is refused, for the answer's body; null: it is not.
  const char* Refusal(const ViewRequest& request) const;

  const std::string& token() const { return token_; }

 private:
  bool IsOurHost(std::string_view host) const;

  std::string host_, token_;
};

/// Whether an address or a name means this machine alone.
bool IsLoopback(std::string_view host);

/// 128 random bits from the operating system, as 32 hexadecimal digits.
std::string RandomToken();

}  // namespace facet
