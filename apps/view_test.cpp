// SPDX-License-Identifier: BSD-2-Clause
// `facet run --view` and `facet view` as programs.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/folders.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using Tcp = boost::asio::ip::tcp;

std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string RunCommandOn(const std::filesystem::path& sequence, const std::filesystem::path& out) {
  return std::string(FACET_PROGRAM) + " run '" + sequence.string() +
         "' --duration 6 --quiet --out '" + out.string() + "'";
}

/// The port in the address that a program prints when it begins to serve.
unsigned short PortFrom(FILE* output) {
  char line[300] = "";
  if (std::fgets(line, sizeof(line), output) == nullptr) return 0;
  const std::string text = line;
  const std::size_t at = text.find("127.0.0.1:");
  if (at == std::string::npos) return 0;
  return static_cast<unsigned short>(std::atoi(text.c_str() + at + 10));
}

/// What a page has got when the program ends the connection.
struct Received {
  std::size_t num_bytes = 0;
  int last_type = 0;  // as view_message.h has it
};

Received ReadAll(unsigned short port) {
  boost::asio::io_context context;
  boost::beast::websocket::stream<Tcp::socket> socket(context);
  socket.next_layer().connect({boost::asio::ip::make_address("127.0.0.1"), port});
  socket.handshake("127.0.0.1", "/live");
  Received received;
  boost::system::error_code error;
  while (!error) {
    boost::beast::flat_buffer buffer;
    socket.read(buffer, error);
    if (error) break;
    const std::string message = boost::beast::buffers_to_string(buffer.data());
    received.num_bytes += message.size();
    received.last_type = message.at(6);
  }
  return received;
}

TEST(ViewTest, ARunThatIsLookedAtGivesTheSameBytes) {
  const auto sequence = testing::DataDir("rendered_room");
  if (!sequence) GTEST_SKIP() << testing::MissingData("rendered_room");
  const std::filesystem::path folder = testing::BuildFolder() / "view_test";
  ASSERT_EQ(std::system(RunCommandOn(*sequence, folder / "alone").c_str()), 0);
  for (const char* threads : {"1", "2"}) {
    const std::string command =
        RunCommandOn(*sequence, folder / "seen") + " --view=0 --view-exit --threads " + threads;
    FILE* const output = popen(command.c_str(), "r");
    ASSERT_NE(output, nullptr);
    const unsigned short port = PortFrom(output);
    ASSERT_NE(port, 0);
    const Received received = ReadAll(port);
    EXPECT_GT(received.num_bytes, 100'000u);
    EXPECT_EQ(received.last_type, 10) << "the end of the run";
    EXPECT_EQ(WEXITSTATUS(pclose(output)), 0);
    for (const char* file :
         {"trajectory.tum", "keyframes.tum", "states.csv", "planes.csv", "mesh.ply", "map.ply"}) {
      const std::string alone = BytesOf(folder / "alone" / file);
      EXPECT_FALSE(alone.empty()) << file;
      EXPECT_TRUE(alone == BytesOf(folder / "seen" / file)) << file << " threads " << threads;
    }
  }
  std::filesystem::remove_all(folder);
}

TEST(ViewTest, WrongUseIsSaidInOneLine) {
  const auto exit_code = [](const std::string& arguments) {
    const std::string command = std::string(FACET_PROGRAM) + " " + arguments + " 2>&1 >/dev/null";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(exit_code("view /nonexistent"), 3);
  const TempFolder folder;
  std::ofstream(folder.path() / "trajectory.tum") << "1 0 0 0 0 0 0 1\n";
  std::ofstream(folder.path() / "summary.json") << std::string(1'000'000, '[');
  EXPECT_EQ(exit_code("view " + folder.path().string()), 3);
  std::filesystem::remove(folder.path() / "summary.json");
  EXPECT_EQ(exit_code("view " + folder.path().string() + " --recording " + folder.path().string()),
            3);
  EXPECT_EQ(exit_code("view " + folder.path().string() + " --recording"), 2);
  EXPECT_EQ(exit_code("view"), 2);
  EXPECT_EQ(exit_code("view a b c"), 2);
  EXPECT_EQ(exit_code("view . --port 65536"), 2);
}

}  // namespace
}  // namespace facet
