// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/standalone_page.h"

#include <string_view>

#include "facet/base/check.h"
#include "facet/viewer/base64.h"
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
