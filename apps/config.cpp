// SPDX-License-Identifier: BSD-2-Clause
// `facet config`: prints the parameters. With --all alone this is config/euroc.yaml.
#include "config.h"

#include <iostream>

#include "load_options.h"

#include "facet/io/errors.h"

namespace facet {

void ConfigCommand(const ConfigArguments& arguments) {
  const LoadedOptions loaded = LoadOptions(arguments.file, arguments.overrides);
  for (const std::string& notice : loaded.notices)
    std::cerr << "facet: note: " << notice << '\n';
  const Audience audience = arguments.all ? Audience::kExperts : Audience::kUsers;
  std::cout << FormatOptions(loaded.options, audience) << std::flush;
  if (!std::cout) throw OutputError("standard output cannot be written");
}

}  // namespace facet
