// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/node_parameters.h"

#include <map>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace robot {
namespace {

using ::testing::HasSubstr;

using Value =
    std::variant<bool, int, double, std::string, std::vector<double>, std::vector<std::string>>;

class Table : public ParameterSource {
 public:
  std::map<std::string, Value> values;

  bool Get(const std::string& name, bool& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, int& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, double& value) const override { return GetAny(name, value); }
  bool Get(const std::string& name, std::string& value) const override {
    return GetAny(name, value);
  }
  bool Get(const std::string& name, std::vector<double>& value) const override {
    return GetAny(name, value);
  }
  bool Get(const std::string& name, std::vector<std::string>& value) const override {
    return GetAny(name, value);
  }
  std::vector<std::string> Names() const override {
    std::vector<std::string> names;
    for (const auto& [name, value] : values)
      names.push_back(name);
    return names;
  }

 private:
  template <class T>
  bool GetAny(const std::string& name, T& value) const {
    const auto found = values.find(name);
    if (found == values.end()) return false;
    value = std::get<T>(found->second);
    return true;
  }
};

const std::vector<double> kUnturned = {1, 2, 3, 0, 0, 0, 1};

std::string ErrorOf(const Table& table) {
  try {
    ReadParameters(table);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "none";
}

TEST(NodeParametersTest, WhatIsSetReplacesTheDefault) {
  Table table;
  table.values = {{"T_imu_left", kUnturned},
                  {"T_left_right", std::vector<double>{0.1, 0, 0, 0, 0, 1, 0}},
                  {"set", std::vector<std::string>{"pipeline=S"}},
                  {"base_frame", std::string("body")},
                  {"start", false},
                  {"imu_queue", 7},
                  {"silence_s", 2.5}};
  const NodeParameters parameters = ReadParameters(table);
  EXPECT_FALSE(parameters.robot.calibration);
  EXPECT_EQ(parameters.robot.mount.T_BC.p, (api::Vec3{{1, 2, 3}}));
  EXPECT_EQ(parameters.robot.mount.T_BC.q[0], 1)
      << "w is the last of the seven, and the first here";
  ASSERT_TRUE(parameters.robot.mount.T_C0C1);
  EXPECT_EQ(parameters.robot.mount.T_C0C1->q[3], 1);
  EXPECT_EQ(parameters.robot.overrides, std::vector<std::string>{"pipeline=S"});
  EXPECT_EQ(parameters.frames.base, "body");
  EXPECT_EQ(parameters.frames.odom, "odom");
  EXPECT_FALSE(parameters.robot.is_started);
  EXPECT_EQ(parameters.imu_queue, 7);
  EXPECT_EQ(parameters.robot.silence_s, 2.5);
}

TEST(NodeParametersTest, WhatIsWrongIsNamed) {
  Table table;
  EXPECT_THAT(ErrorOf(table), HasSubstr("~T_imu_left"));
  table.values = {{"T_imu_left", std::vector<double>{1, 2, 3}}};
  EXPECT_THAT(ErrorOf(table), HasSubstr("[x, y, z, qx, qy, qz, qw]"));
  table.values = {{"T_imu_left", kUnturned}, {"imu_que", 3}};
  EXPECT_THAT(ErrorOf(table), HasSubstr("~imu_que is not a parameter"));
  table.values = {{"T_imu_left", kUnturned}, {"image_queue", 0}};
  EXPECT_THAT(ErrorOf(table), HasSubstr("~image_queue"));
}

TEST(NodeParametersTest, ACalibrationThatCannotBeReadIsAnErrorOfItsOwn) {
  Table table;
  table.values = {{"calibration", std::string("no/such/file.yaml")}};
  EXPECT_THROW(ReadParameters(table), CalibrationError);
}

}  // namespace
}  // namespace robot
}  // namespace facet
