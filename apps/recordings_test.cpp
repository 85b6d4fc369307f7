// SPDX-License-Identifier: BSD-2-Clause
// Real recordings, rewritten as bags by programs that are not ours: the run is that of the folder,
// byte by byte. The writers are in src/facet/testing/recording/writers; what they need is named
// where it is missing.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/asl_dataset.h"
#include "facet/io/calibration_writer.h"
#include "facet/io/image_reader.h"
#include "facet/io/trajectory_file.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_images.h"

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

struct StampedPosition {
  Timestamp t;
  Vector3d p;
};

std::vector<StampedPosition> Positions(const fs::path& file) {
  std::vector<StampedPosition> positions;
  for (const auto& pose : ReadTrajectory(file).poses)
    positions.push_back({pose.t, pose.T_WB.p});
  return positions;
}

TEST(McapConversionTest, TheTrajectoryIsThatOfTheFolder) {
  const auto sequence = testing::DataDir("euroc_mh01_handheld");
  if (!sequence) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  const TempFolder folder;
  WriteRawCopy(*sequence, folder / "raw");
  const std::string calibration = " --calibration " + Quoted(*sequence);
  const auto run = [&](const fs::path& recording, const std::string& out, const std::string& more) {
    const ProgramRun program = RunFacet("run " + Quoted(recording) + more + " --quiet --duration " +
                                        kSeconds + " --out " + Quoted(folder / out));
    EXPECT_EQ(program.exit_code, 0) << program.err;
    return folder / out / "trajectory.tum";
  };
  const fs::path expected = run(folder / "raw", "asl", calibration);
  ASSERT_GT(Positions(expected).size(), 40u);
  for (const char* compression : {"zstd", "none"}) {
    const fs::path file = folder / (std::string(compression) + ".mcap");
    const ProgramRun convert = RunFacet("convert " + Quoted(folder / "raw") + " " + Quoted(file) +
                                        calibration + " --quiet --compression " + compression);
    ASSERT_EQ(convert.exit_code, 0) << convert.err;
    const fs::path same = run(file, "same", calibration);
    EXPECT_TRUE(ReadText(same) == ReadText(expected)) << "with --calibration";

    const auto positions = Positions(run(file, "own", "")), wanted = Positions(expected);
    ASSERT_EQ(positions.size(), wanted.size()) << "with the calibration in the recording";
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_EQ(positions[i].t, wanted[i].t);
      EXPECT_LE((positions[i].p - wanted[i].p).norm(), 1e-6) << i;
    }
  }
}

TEST(McapConversionTest, TheReferenceImplementationReadsTheFile) {
  if (RunShell("command -v node").exit_code != 0) GTEST_SKIP() << "no node";
  const TempFolder folder;
  WriteTestSequence(folder / "seq");
  const fs::path file = folder / "a.mcap";
  const ProgramRun convert = RunFacet("convert " + Quoted(folder / "seq") + " " + Quoted(file) +
                                      " --quiet --compression none");
  ASSERT_EQ(convert.exit_code, 0) << convert.err;
  const ProgramRun reader =
      RunShell("node " + Quoted(fs::path(FACET_WRITERS) / "read_mcap.mjs") + " " + Quoted(file));
  if (reader.exit_code == kToolMissing) GTEST_SKIP() << reader.out;
  ASSERT_EQ(reader.exit_code, 0) << reader.err;
  const auto has_line = [&](const std::string& begin, const std::string& part) {
    const std::vector<std::string> lines = Lines(reader.out);
    return std::ranges::any_of(lines, [&](const std::string& line) {
      return line.starts_with(begin) && line.find(part) != std::string::npos;
    });
  };
  EXPECT_TRUE(has_line("/cam0/image_raw sensor_msgs/msg/Image 12 ", R"("encoding":"mono8")"));
  EXPECT_TRUE(has_line("/cam1/image_raw sensor_msgs/msg/Image 12 ", R"("width":160)"));
  EXPECT_TRUE(has_line("/cam1/camera_info sensor_msgs/msg/CameraInfo 12 ",
                       R"("d":[-0.28340811,0.07395907,0.00019359,0.0000176187114,0])"));
  EXPECT_TRUE(has_line("/imu0 sensor_msgs/msg/Imu 151 ",
                       R"("linear_acceleration":{"x":9.81,"y":0.01,"z":0.02})"));
  EXPECT_TRUE(has_line("/imu0 sensor_msgs/msg/Imu 151 ",
                       R"("stamp":{"sec":1403636584,"nanosec":663555584})"));
  EXPECT_TRUE(has_line("/tf_static tf2_msgs/msg/TFMessage 1 ", R"("child_frame_id":"cam1")"));
}

/// A sequence in the layout of TUM-VI: 16-bit PNG, Kalibr's calibration in dso/, poses in mocap0/.
void WriteTumVi(const fs::path& sequence, const fs::path& out) {
  WriteRawCopy(sequence, out);
  ImageReader reader;
  for (const char* camera : {"cam0", "cam1"}) {
    const fs::path folder = out / "mav0" / camera;
    for (const auto& entry : fs::directory_iterator(folder / "data")) {
      cv::Mat grey;
      reader.Read(entry.path(), grey);
      TestImage image{grey.cols, grey.rows, 1, {}};
      for (auto pixel = grey.begin<std::uint8_t>(); pixel != grey.end<std::uint8_t>(); ++pixel)
        image.samples.push_back(static_cast<std::uint16_t>(*pixel * 257));
      WriteText(fs::path(entry.path()).replace_extension(".png"), EncodePng(image, {16}));
    }
    EditLines(folder / "data.csv", [](std::vector<std::string>& lines) {
      for (std::string& line : lines) {
        if (line.ends_with(".pgm")) line.replace(line.size() - 3, 3, "png");
      }
    });
  }
  fs::create_directories(out / "dso");
  WriteCalibration(out / "dso/camchain.yaml", AslDataset(sequence).rig());
  fs::copy_file(sequence / "mav0/imu0/sensor.yaml", out / "dso/imu_config.yaml");
  std::vector<std::string> truth = Lines(ReadText(FindTruth(sequence)));
  for (std::string& line : truth) {
    std::size_t end = 0;
    for (int i = 0; i < 8 && end != std::string::npos; ++i)
      end = line.find(',', end + 1);
    line.resize(std::min(end, line.size()));
  }
  WriteText(out / "mav0/mocap0/data.csv", JoinLines(truth));
}

TEST(TumViTest, IsRunAndEvaluated) {
  const auto sequence = testing::DataDir("euroc_mh01_handheld");
  if (!sequence) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  const TempFolder folder;
  const fs::path tum = folder / "dataset-room1_512_16";
  WriteTumVi(*sequence, tum);
  const std::string common = std::string(" --quiet --duration ") + kSeconds + " --out ";
  const ProgramRun expected =
      RunFacet("run " + Quoted(*sequence) + " --calibration " + Quoted(tum / "dso/camchain.yaml") +
               " --imu-calibration " + Quoted(tum / "dso/imu_config.yaml") + common +
               Quoted(folder / "asl"));
  ASSERT_EQ(expected.exit_code, 0) << expected.err;
  const ProgramRun run = RunFacet("run " + Quoted(tum) + common + Quoted(folder / "tum"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(ReadText(folder / "tum/trajectory.tum") == ReadText(folder / "asl/trajectory.tum"));

  const ProgramRun evaluation = RunFacet("evaluate " + Quoted(folder / "tum") + " --truth " +
                                         Quoted(tum) + " --parts trajectory");
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.err;
  const auto figures = nlohmann::json::parse(ReadText(folder / "tum/evaluation.json"));
  EXPECT_GT(figures["coverage"].get<double>(), 0.8);
  EXPECT_LT(figures["ate"]["rmse_m"].get<double>(), 0.05);
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
