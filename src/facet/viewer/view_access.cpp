// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_access.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>
#include <utility>

namespace facet {
namespace {

/// "name:port" or "[address]:port" without the port and the brackets.
std::string_view WithoutPort(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? std::string_view() : host.substr(1, end - 1);
  }
  return host.substr(0, host.find(':'));
}

bool SameToken(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace

ViewTarget ParseTarget(std::string_view target) {
  const std::size_t mark = target.find('?');
  ViewTarget parsed{target.substr(0, mark), {}};
  if (mark == std::string_view::npos) return parsed;
  std::string_view query = target.substr(mark + 1);
  constexpr std::string_view kToken = "token=";
  while (!query.empty()) {
    const std::string_view part = query.substr(0, query.find('&'));
    if (part.starts_with(kToken)) parsed.token = part.substr(kToken.size());
    query.remove_prefix(std::min(query.size(), part.size() + 1));
  }
  return parsed;
}

ViewAccess::ViewAccess(std::string host, std::string token)
    : host_(std::move(host)), token_(std::move(token)) {}

bool ViewAccess::IsOurHost(std::string_view host) const {
  // Which names this machine has in other networks is not known; there the token decides.
  if (!IsLoopback(host_)) return !host.empty();
  return IsLoopback(WithoutPort(host));
}

const char* ViewAccess::Refusal(const ViewRequest& request) const {
  if (!IsOurHost(request.host))
    return "This address is not one that the viewer was started for; see --host.";
  if (request.origin) {
    constexpr std::string_view kScheme = "http://";
    const bool is_same = request.origin->starts_with(kScheme) &&
                         request.origin->substr(kScheme.size()) == request.host;
    if (!is_same) return "Pages of other sites may not use the viewer.";
  }
  if (!token_.empty() && !SameToken(ParseTarget(request.target).token, token_))
    return "The address lacks the right token; the program prints it when it starts.";
  return nullptr;
}

bool IsLoopback(std::string_view host) {
  return host == "localhost" || host == "127.0.0.1" || host == "::1";
}

std::string RandomToken() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(random()));
    token += text.data();
  }
  return token;
}

}  // namespace facet
