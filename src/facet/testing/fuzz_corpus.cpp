// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/fuzz_corpus.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "facet/base/check.h"
#include "facet/testing/folders.h"

namespace facet::testing {

namespace {

FuzzInput FromHex(const std::string& line, const std::string& where) {
  FuzzInput input(line.size() / 2);
  for (std::size_t i = 0; i < input.size(); ++i) {
    const char* digits = line.data() + 2 * i;
    if (std::from_chars(digits, digits + 2, input[i], 16).ptr != digits + 2)
      throw std::runtime_error(where + ": hexadecimal digits are expected");
  }
  return input;
}

// Of the lines that begin with `prefix`, what follows it.
std::vector<FuzzInput> ReadInputs(const std::string& name, const std::string& prefix) {
  const std::filesystem::path file = SourceFolder() / "testdata" / "fuzz" / (name + ".txt");
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<FuzzInput> inputs;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.empty() || line.front() == '#' || !line.starts_with(prefix)) continue;
    const std::string where = file.string() + ":" + std::to_string(number);
    inputs.push_back(FromHex(line.substr(prefix.size()), where));
  }
  return inputs;
}

}  // namespace

std::vector<FuzzInput> SavedFuzzInputs(const std::string& name) {
  return ReadInputs(name, "");
}

std::vector<FuzzInput> SavedFuzzInputs(const std::string& name, const std::string& reader) {
  return ReadInputs(name, reader + '\t');
}

std::string ToHex(const FuzzInput& input) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : input) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

int NumFuzzRuns(int usual) {
  const char* text = std::getenv("FACET_FUZZ_RUNS");  // NOLINT(concurrency-mt-unsafe)
  const int num = text == nullptr ? usual : std::atoi(text);
  FACET_CHECK(num > 0) << "FACET_FUZZ_RUNS is " << num;
  return num;
}

FuzzInput Damaged(FuzzInput input, Rng& rng) {
  for (int i = rng.Index(4); i >= 0; --i) {
    const auto size = static_cast<int>(input.size());
    const auto at = input.begin() + rng.Index(size + 1);
    const auto length = std::min<std::ptrdiff_t>(input.end() - at, 1 + rng.Index(8));
    const auto byte = static_cast<std::uint8_t>(rng.Index(256));
    switch (rng.Index(4)) {
      case 0:
        if (at != input.end()) *at = byte;
        break;
      case 1:
        input.erase(at, at + length);
        break;
      case 2: {
        const FuzzInput part(at, at + length);
        input.insert(input.begin() + rng.Index(size + 1), part.begin(), part.end());
        break;
      }
      default:
        input.insert(at, byte);
        break;
    }
  }
  return input;
}

std::string ArgumentValue(int num_arguments,
                          const char* const* arguments,
                          const std::string& name) {
  const std::string option = "--" + name + "=";
  for (int i = 1; i < num_arguments; ++i) {
    const std::string argument = arguments[i];
    if (argument.starts_with(option)) return argument.substr(option.size());
  }
  return {};
}

void WriteSeedsIfAsked(int num_arguments,
                       const char* const* arguments,
                       const std::vector<FuzzInput>& inputs) {
  const std::filesystem::path folder = ArgumentValue(num_arguments, arguments, "write-seeds");
  if (folder.empty()) return;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    std::ofstream stream(folder / ("seed-" + std::to_string(i)), std::ios::binary);
    for (const std::uint8_t byte : inputs[i])
      stream.put(static_cast<char>(byte));
  }
  std::exit(0);  // NOLINT(concurrency-mt-unsafe)
}

void AbortOnProblem(const std::string& problem) {
  if (problem.empty()) return;
  std::fprintf(stderr, "broken promise: %s\n", problem.c_str());
  std::abort();
}

}  // namespace facet::testing
