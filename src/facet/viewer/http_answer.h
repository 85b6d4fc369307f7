// SPDX-License-Identifier: BSD-2-Clause
// What the viewer answers to a plain HTTP request.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "facet/viewer/view_access.h"
#include "facet/viewer/view_server.h"

namespace facet {

struct HttpQuestion {
  ViewRequest request;
  bool is_get = true;  ///< or HEAD
  bool takes_gzip = false;
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  bool is_gzip = false;
  std::string file_name;  ///< under which a browser saves it; empty: it shows it
};

/// The page's assets and the downloads. Not thread-safe.
class HttpAnswers {
 public:
  HttpAnswers(const ViewAccess& access, std::vector<ViewDownload> downloads);

  void SetDownloads(std::vector<ViewDownload> downloads);

  HttpAnswer Answer(const HttpQuestion& question) const;

 private:
  HttpAnswer Download(std::string_view name) const;

  struct Page {
    std::string type, bytes, gzip;
  };
  const ViewAccess& access_;
  std::map<std::string, Page, std::less<>> pages_;  // by path
  std::map<std::string, ViewDownload, std::less<>> downloads_;
};

/// In gzip's format.
std::string Gzip(std::string_view bytes);

}  // namespace facet
