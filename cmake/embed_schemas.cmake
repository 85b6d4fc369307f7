# SPDX-License-Identifier: BSD-2-Clause
# cmake -D folder=src/facet/publish/schemas -D output=FILE -P embed_schemas.cmake
# Writes a C++ source with the schemas of messages as texts.

set(entries "")
file(GLOB files RELATIVE ${folder} ${folder}/*.json)
list(SORT files)
foreach(file ${files})
  string(REGEX REPLACE "\\.json$" "" name ${file})
  file(READ ${folder}/${file} bytes HEX)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  string(APPEND entries "    {\"${name}\", \"${bytes}\"},\n")
endforeach()
file(WRITE ${output} "// Made by cmake/embed_schemas.cmake; do not edit.
#include \"facet/publish/channels.h\"

namespace facet {

std::string_view SchemaText(std::string_view name) {
  struct Schema {
    std::string_view name, text;
  };
  static constexpr Schema kSchemas[] = {
${entries}  };
  for (const Schema& schema : kSchemas) {
    if (schema.name == name) return schema.text;
  }
  return {};
}

}  // namespace facet
")
