// SPDX-License-Identifier: BSD-2-Clause
#include "load_options.h"

#include <algorithm>

#include "facet/frontend/patch_kernels.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"

namespace facet {

LoadedOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides) {
  LoadedOptions loaded;
  const std::vector<ConfigField> fields = ListFields(loaded.options);
  if (!file.empty()) loaded.notices = ApplyConfig(ReadConfigFile(file), fields, RetiredOptions());
  for (std::string& notice : ApplyOverrides(overrides, fields, RetiredOptions()))
    loaded.notices.push_back(std::move(notice));
  const std::string& simd = loaded.options.frontend.klt.simd;
  if (FindPatchKernels(simd) == nullptr) {
    throw ConfigError("frontend.klt.simd = '" + simd +
                      "': this machine has no such instructions; allowed: auto | scalar");
  }
  return loaded;
}

std::string FormatOptions(VioOptions options, Audience audience) {
  const std::vector<ConfigField> fields = ListFields(options);
  const std::string head = "# Facet's parameters: value, meaning, [what is allowed].";
  if (audience == Audience::kExperts) return head + "\n" + FormatConfig(fields);
  const auto num_others = std::count_if(fields.begin(), fields.end(), [](const ConfigField& field) {
    return field.audience == Audience::kExperts;
  });
  return head + " `facet config --all` prints " + std::to_string(num_others) + " more.\n" +
         FormatConfig(fields, audience);
}

}  // namespace facet
