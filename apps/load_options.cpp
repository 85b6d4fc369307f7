// SPDX-License-Identifier: BSD-2-Clause
#include "load_options.h"

#include "facet/io/config_file.h"

namespace facet {

VioOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides) {
  VioOptions options;
  const std::vector<ConfigField> fields = ListFields(options);
  if (!file.empty()) ApplyConfig(ReadConfigFile(file), fields);
  for (const std::string& text : overrides) {
    const ConfigEntry entry = ParseOverride(text);
    ApplyConfig({&entry, 1}, fields);
  }
  return options;
}

std::string FormatOptions(VioOptions options) {
  return "# Facet's parameters: value, meaning, [what is allowed]. `facet config` prints the "
         "defaults.\n" +
         FormatConfig(ListFields(options));
}

}  // namespace facet
