// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/http_answer.h"

#include <exception>
#include <utility>

#include <zlib.h>

#include "facet/base/check.h"
#include "facet/viewer/page_assets.h"

namespace facet {
namespace {

HttpAnswer Plain(int status, std::string text) {
  HttpAnswer answer;
  answer.status = status;
  answer.body = std::move(text) + "\n";
  return answer;
}

}  // namespace

HttpAnswers::HttpAnswers(const ViewAccess& access, std::vector<ViewDownload> downloads)
    : access_(access) {
  for (const PageAsset& asset : PageAssets()) {
    pages_[std::string(asset.path)] = {
        std::string(asset.type), std::string(asset.bytes), Gzip(asset.bytes)};
  }
  SetDownloads(std::move(downloads));
}

void HttpAnswers::SetDownloads(std::vector<ViewDownload> downloads) {
  downloads_.clear();
  for (ViewDownload& download : downloads)
    downloads_[download.name] = std::move(download);
}

HttpAnswer HttpAnswers::Answer(const HttpQuestion& question) const {
  const std::string_view path = ParseTarget(question.request.target).path;
  const auto page = pages_.find(path);
  // The parts that the page loads are the same for everybody, and it does not pass the token on.
  ViewRequest request = question.request;
  const std::string with_token = "?token=" + access_.token();
  if (page != pages_.end() && path != "/") request.target = with_token;
  if (const char* refusal = access_.Refusal(request)) return Plain(403, refusal);
  if (!question.is_get) return Plain(405, "Only GET and HEAD.");
  constexpr std::string_view kDownload = "/download/";
  if (path.starts_with(kDownload)) return Download(path.substr(kDownload.size()));
  if (page == pages_.end()) return Plain(404, "There is no such page.");
  HttpAnswer answer;
  answer.type = page->second.type;
  answer.is_gzip = question.takes_gzip;
  answer.body = question.takes_gzip ? page->second.gzip : page->second.bytes;
  return answer;
}

HttpAnswer HttpAnswers::Download(std::string_view name) const {
  const auto download = downloads_.find(name);
  if (download == downloads_.end()) return Plain(404, "There is no such download.");
  try {
    HttpAnswer answer;
    answer.type = download->second.type;
    answer.body = download->second.make();
    answer.file_name = name.substr(name.rfind('/') + 1);
    return answer;
  } catch (const std::exception& error) {
    return Plain(500, error.what());
  }
}

std::string Gzip(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzipWindow = 15 + 16, kMemory = 8;
  int status = deflateInit2(
      &stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemory, Z_DEFAULT_STRATEGY);
  FACET_CHECK(status == Z_OK) << "zlib says " << status;
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  std::string in(bytes);  // zlib wants it writable
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  status = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  FACET_CHECK(status == Z_STREAM_END) << "zlib says " << status;
  return out;
}

}  // namespace facet
