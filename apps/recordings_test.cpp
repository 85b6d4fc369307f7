// SPDX-License-Identifier: BSD-2-Clause
// Real recordings, rewritten as bags by programs that are not ours: the run is that of the folder,
// byte by byte. The writers are in src/facet/testing/recording/writers; what they need is named
// where it is missing.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/image_reader.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr int kToolMissing = 77;
constexpr const char* kSeconds = "4";

struct Rewriting {
  std::string name;
  std::string recording;
  std::string writer;  ///< a Python script
  std::string out;     ///< file or folder that it writes
  std::string more;    ///< arguments
  bool is_raw = false;
};

std::string Quoted(const fs::path& path) {
  return "'" + path.string() + "'";
}

/// The first seconds of a sequence with PGM images, which the writers turn into raw ones.
void WriteRawCopy(const fs::path& sequence, const fs::path& out) {
  const AslDataset dataset(sequence);
  ImageReader reader;
  const Timestamp last = dataset.frames().front().t + Duration{4500000000};
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path folder = out / "mav0" / ("cam" + std::to_string(camera));
    std::string csv = "#timestamp [ns],filename\n";
    for (const FrameEntry& frame : dataset.frames()) {
      if (frame.t > last || !frame.HasRight()) continue;
      cv::Mat grey;
      reader.Read(dataset.ImagePath(camera, camera == 0 ? frame.left : frame.right), grey);
      const std::string name = std::to_string(frame.t.ns) + ".pgm";
      const std::string size = std::to_string(grey.cols) + " " + std::to_string(grey.rows);
      WriteText(folder / "data" / name,
                "P5 " + size + " 255\n" + std::string(grey.begin<char>(), grey.end<char>()));
      csv += std::to_string(frame.t.ns) + "," + name + "\n";
    }
    WriteText(folder / "data.csv", csv);
  }
  fs::create_directories(out / "mav0" / "imu0");
  fs::copy_file(sequence / "mav0/imu0/data.csv", out / "mav0/imu0/data.csv");
}

class RecordingsTest : public ::testing::TestWithParam<Rewriting> {
 protected:
  std::string Trajectory(const fs::path& recording, const fs::path& calibration) const {
    const ProgramRun run =
        RunFacet("run " + Quoted(recording) + " --calibration " + Quoted(calibration) +
                 " --quiet --duration " + kSeconds + " --out " + Quoted(folder_ / "out"));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? ReadText(folder_ / "out/trajectory.tum") : std::string();
  }
  TempFolder folder_;
};

TEST_P(RecordingsTest, TheTrajectoryIsThatOfTheFolder) {
  const Rewriting& c = GetParam();
  const auto sequence = testing::DataDir(c.recording);
  if (!sequence) GTEST_SKIP() << testing::MissingData(c.recording);
  fs::path source = *sequence;
  if (c.is_raw) {
    source = folder_ / "raw";
    WriteRawCopy(*sequence, source);
  }
  const fs::path out = folder_ / c.out;
  const ProgramRun writer =
      RunShell("/usr/bin/python3 " + Quoted(fs::path(FACET_WRITERS) / c.writer) + " " +
               Quoted(source) + " " + Quoted(out) + " 4.5 " + c.more);
  if (writer.exit_code == kToolMissing) GTEST_SKIP() << writer.out;
  ASSERT_EQ(writer.exit_code, 0) << writer.err;
  const std::string expected = Trajectory(*sequence, *sequence);
  ASSERT_GT(expected.size(), 1000u);
  EXPECT_TRUE(Trajectory(out, *sequence) == expected) << "trajectories differ";
}

INSTANTIATE_TEST_SUITE_P(
    Kinds,
    RecordingsTest,
    ::testing::Values(
        Rewriting{"ros1_handheld", "euroc_mh01_handheld", "write_ros1_bag.py", "a.bag", "none"},
        Rewriting{"ros1_raw_lz4", "euroc_mh01_handheld", "write_ros1_bag.py", "a.bag", "lz4", true},
        Rewriting{"ros1_room_bz2", "rendered_room", "write_ros1_bag.py", "a.bag", "bz2"},
        Rewriting{"db3_handheld_split", "euroc_mh01_handheld", "write_db3.py", "bag", "3"},
        Rewriting{"db3_raw", "euroc_mh01_handheld", "write_db3.py", "bag", "1", true},
        Rewriting{"db3_room", "rendered_room", "write_db3.py", "bag", "1"},
        Rewriting{"mcap_handheld", "euroc_mh01_handheld", "write_mcap.py", "a.mcap", ""},
        Rewriting{
            "mcap_raw_unchunked", "euroc_mh01_handheld", "write_mcap.py", "a.mcap", "0", true},
        Rewriting{"mcap_room", "rendered_room", "write_mcap.py", "a.mcap", ""}),
    [](const ::testing::TestParamInfo<Rewriting>& one) { return one.param.name; });

}  // namespace
}  // namespace facet
