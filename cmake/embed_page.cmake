# SPDX-License-Identifier: BSD-2-Clause
# cmake -D folder=viewer/dist -D output=FILE -P embed_page.cmake
# Writes a C++ source with the files of the viewer's page as byte strings.

set(types html "text/html; charset=utf-8" js "text/javascript; charset=utf-8" css "text/css; charset=utf-8"
  svg "image/svg+xml" txt "text/plain; charset=utf-8")
set(entries "")
set(arrays "")
set(number 0)
file(GLOB_RECURSE files RELATIVE ${folder} ${folder}/*)
list(SORT files)
foreach(file ${files})
  string(REGEX REPLACE ".*\\." "" suffix ${file})
  list(FIND types ${suffix} place)
  if(place EQUAL -1)
    message(FATAL_ERROR "${folder}/${file}: cmake/embed_page.cmake does not know its type")
  endif()
  math(EXPR place "${place} + 1")
  list(GET types ${place} type)
  set(path "/${file}")
  if(file STREQUAL "index.html")
    set(path "/")
  endif()
  file(READ ${folder}/${file} bytes HEX)
  string(LENGTH "${bytes}" length)
  math(EXPR length "${length} / 2")
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  string(APPEND arrays "constexpr char kFile${number}[] = \"${bytes}\";\n")
  string(APPEND entries "    PageAsset{\"${path}\", \"${type}\", {kFile${number}, ${length}}},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${output} "// Made by cmake/embed_page.cmake; do not edit.
#include <array>

#include \"facet/viewer/page_assets.h\"

namespace facet {
namespace {

${arrays}
constexpr std::array kAssets = {
${entries}};

}  // namespace

std::span<const PageAsset> PageAssets() {
  return kAssets;
}

}  // namespace facet
")
