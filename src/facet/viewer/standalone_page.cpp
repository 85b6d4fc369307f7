// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/standalone_page.h"

#include <algorithm>
#include <string_view>

#include "facet/base/check.h"
#include "facet/viewer/page_assets.h"
#include "facet/viewer/view_board.h"

namespace facet {
namespace {

std::string Asset(std::string_view path) {
  for (const PageAsset& asset : PageAssets()) {
    if (asset.path == path) return std::string(asset.bytes);
  }
  FACET_CHECK(false) << "the page lacks " << path;
  return "";
}

std::string Base64(const std::string& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (int k = 3; k >= 0; --k)
      text += kDigits[word >> (6 * k) & 63];
  }
  const std::size_t padding = (3 - bytes.size() % 3) % 3;
  std::fill(text.end() - static_cast<std::ptrdiff_t>(padding), text.end(), '=');
  return text;
}

/// Replaces the element between two marks, both included.
void Replace(std::string_view begin, std::string_view end, const std::string& by, std::string& in) {
  const std::size_t from = in.find(begin);
  const std::size_t to = in.find(end, from);
  FACET_CHECK(from != std::string::npos && to != std::string::npos) << "the page lacks " << begin;
  in.replace(from, to + end.size() - from, by);
}

/// A script's end inside it would end it there.
std::string ForScript(std::string script) {
  for (std::size_t i = 0; (i = script.find("</script", i)) != std::string::npos; i += 3)
    script.replace(i, 2, "<\\/");
  return script;
}

}  // namespace

std::string StandalonePage(const ResultView& view) {
  ViewBoard board;
  view.PostTo(board);
  std::string data;
  std::uint64_t number = 0;
  while (const auto next = board.NextAfter(number)) {
    data += "<script type=\"application/x-facet\">" + Base64(*next->message) + "</script>\n";
    number = next->number;
  }
  std::string page = Asset("/");
  Replace("<script", "</script>", "", page);
  Replace("<link rel=\"stylesheet\"", ">", "<style>" + Asset("/page.css") + "</style>", page);
  Replace("</body>",
          "</html>",
          data + "<script type=\"module\">" + ForScript(Asset("/page.js")) +
              "</script>\n</body>\n</html>",
          page);
  return page;
}

}  // namespace facet
