// SPDX-License-Identifier: BSD-2-Clause
// `facet config`: prints the parameters. With --all alone this is config/euroc.yaml.
#include "config.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "load_options.h"
#include <CLI/CLI.hpp>

#include "facet/io/errors.h"

namespace facet {

void AddConfigCommand(CLI::App& app) {
  struct Arguments {
    std::string file;
    std::vector<std::string> overrides;
    bool all = false;
  };
  auto* command =
      app.add_subcommand("config", "Print the parameters with their values and meanings");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--config", arguments->file, "YAML with any subset of the parameters");
  command
      ->add_option("--set", arguments->overrides, "key.path=value, repeatable; wins over the file")
      ->allow_extra_args(false);
  command->add_flag("--all", arguments->all, "every parameter, also those for experts");
  command->callback([arguments] {
    const LoadedOptions loaded = LoadOptions(arguments->file, arguments->overrides);
    for (const std::string& notice : loaded.notices)
      std::cerr << "facet: note: " << notice << '\n';
    const Audience audience = arguments->all ? Audience::kExperts : Audience::kUsers;
    std::cout << FormatOptions(loaded.options, audience) << std::flush;
    if (!std::cout) throw OutputError("standard output cannot be written");
  });
}

}  // namespace facet
