// SPDX-License-Identifier: BSD-2-Clause
// `facet config`: prints every parameter. Without options this is config/euroc.yaml.
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
  };
  auto* command = app.add_subcommand("config", "Print every parameter with its value and meaning");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--config", arguments->file, "YAML with any subset of the parameters");
  command
      ->add_option("--set", arguments->overrides, "key.path=value, repeatable; wins over the file")
      ->allow_extra_args(false);
  command->callback([arguments] {
    std::cout << FormatOptions(LoadOptions(arguments->file, arguments->overrides)) << std::flush;
    if (!std::cout) throw OutputError("standard output cannot be written");
  });
}

}  // namespace facet
