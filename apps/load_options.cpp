// SPDX-License-Identifier: BSD-2-Clause
#include "load_options.h"

#include "facet/io/config_file.h"
#include "facet/io/errors.h"

namespace facet {

VioOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides) {
  VioOptions options;
  const std::vector<ConfigField> fields = ListFields(options);
  if (!file.empty()) ApplyConfig(ReadConfigFile(file), fields);
  ApplyOverrides(overrides, fields);
  const std::string problem = Contradiction(options);
  if (!problem.empty()) throw ConfigError(problem);
  return options;
}

std::string FormatOptions(VioOptions options) {
  return "# Facet's parameters: value, meaning, [what is allowed]. `facet config` prints the "
         "defaults.\n" +
         FormatConfig(ListFields(options));
}

}  // namespace facet
