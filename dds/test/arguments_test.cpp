// SPDX-License-Identifier: BSD-2-Clause
#include "arguments.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet::dds {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

std::string ErrorOf(const std::vector<std::string>& words) {
  try {
    ReadArguments(words);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "none";
}

std::string WriteFile(const std::string& name, const std::string& text) {
  const std::string file = ::testing::TempDir() + name;
  std::ofstream(file) << text;
  return file;
}

TEST(ArgumentsTest, NamesAreThoseOfRos2) {
  const Arguments arguments = ReadArguments({"--ros-args",
                                             "-r",
                                             "left/image_raw:=/cam0/image_raw",
                                             "-r",
                                             "~/pose:=fused",
                                             "--remap",
                                             "__node:=vio",
                                             "-r",
                                             "__ns:=/drone"});
  const NodeNames& names = arguments.names;
  EXPECT_EQ(names.Topic("left/image_raw"), "rt/cam0/image_raw");
  EXPECT_EQ(names.Topic("right/image_raw"), "rt/drone/right/image_raw");
  EXPECT_EQ(names.Topic("~/odometry"), "rt/drone/vio/odometry");
  EXPECT_EQ(names.Topic("~/pose"), "rt/drone/fused");
  EXPECT_EQ(names.Topic("/tf"), "rt/tf");
  EXPECT_EQ(names.Request("~/start"), "rq/drone/vio/startRequest");
  EXPECT_EQ(names.Reply("~/start"), "rr/drone/vio/startReply");
  EXPECT_EQ(NodeNames().Topic("~/odometry"), "rt/facet/odometry");
}

TEST(ArgumentsTest, ParametersHaveTheTypesOfYaml) {
  const Arguments arguments = ReadArguments({"-p",
                                             "start:=false",
                                             "-p",
                                             "imu_queue:=7",
                                             "-p",
                                             "silence_s:=2",
                                             "-p",
                                             "base_frame:=body",
                                             "-p",
                                             "T_imu_left:=[0, 0, 0.5, 0, 0, 0, 1]",
                                             "-p",
                                             "set:=[pipeline=S]",
                                             "-p",
                                             "reliable:=true"});
  const robot::NodeParameters parameters = robot::ReadParameters(arguments.parameters);
  EXPECT_FALSE(parameters.robot.is_started);
  EXPECT_EQ(parameters.imu_queue, 7);
  EXPECT_EQ(parameters.robot.silence_s, 2);
  EXPECT_EQ(parameters.frames.base, "body");
  EXPECT_EQ(parameters.robot.mount.T_BC.p[2], 0.5);
  EXPECT_EQ(parameters.robot.overrides, std::vector<std::string>{"pipeline=S"});
}

TEST(ArgumentsTest, AFileHasParametersOfAllNodesAndOfThisOne) {
  const std::string file =
      WriteFile("facet_dds_parameters.yaml",
                "/**:\n  ros__parameters:\n    imu_queue: 5\n    start: false\n"
                "vio:\n  ros__parameters:\n    imu_queue: 6\n"
                "other:\n  ros__parameters:\n    nonsense: 1\n");
  const Arguments arguments =
      ReadArguments({"--params-file", file, "-r", "__node:=vio", "-p", "image_queue:=9"});
  int imu_queue = 0, image_queue = 0;
  EXPECT_TRUE(arguments.parameters.Get("imu_queue", imu_queue));
  EXPECT_TRUE(arguments.parameters.Get("image_queue", image_queue));
  EXPECT_EQ(imu_queue, 6);
  EXPECT_EQ(image_queue, 9);
  EXPECT_THAT(arguments.parameters.Names(),
              UnorderedElementsAre("imu_queue", "image_queue", "start"));
  std::filesystem::remove(file);
}

TEST(ArgumentsTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(ErrorOf({"--calibration"}), HasSubstr("--calibration"));
  EXPECT_THAT(ErrorOf({"-p", "calibration"}), HasSubstr("NAME:=VALUE"));
  EXPECT_THAT(ErrorOf({"-p"}), HasSubstr("-p"));
  EXPECT_THAT(ErrorOf({"-r", "__ns:=drone"}), HasSubstr("begins with /"));
  EXPECT_THAT(ErrorOf({"-p", "set:=[a"}), HasSubstr("set"));
  EXPECT_THAT(ErrorOf({"--params-file", "no/such.yaml"}), HasSubstr("no/such.yaml"));
  const std::string file =
      WriteFile("facet_dds_other.yaml", "other:\n  ros__parameters:\n    a: 1\n");
  EXPECT_THAT(ErrorOf({"--params-file", file}), HasSubstr("nothing for a node"));
  const std::string list = WriteFile("facet_dds_list.yaml", "- 1\n- 2\n");
  EXPECT_THAT(ErrorOf({"--params-file", list}), HasSubstr("a map of nodes"));
  std::filesystem::remove(file);
  std::filesystem::remove(list);
  int number = 0;
  EXPECT_THROW(ReadArguments({"-p", "imu_queue:=many"}).parameters.Get("imu_queue", number),
               api::Error);
}

TEST(ArgumentsTest, HelpIsAsked) {
  EXPECT_TRUE(ReadArguments({"--help"}).wants_help);
  EXPECT_FALSE(ReadArguments({}).wants_help);
}

}  // namespace
}  // namespace facet::dds
