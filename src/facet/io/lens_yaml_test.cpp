// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/lens_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/folders.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/lens_examples.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string ListOf(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    char number[40];
    std::snprintf(number, sizeof(number), "%.17g", value);
    text += (text.empty() ? "" : ", ") + std::string(number);
  }
  return "[" + text + "]";
}

class LensYamlTest : public ::testing::Test {
 protected:
  CameraModel Read(const std::string& text, int width = 640, int height = 480) {
    const auto file = folder_ / "camera.yaml";
    WriteText(file, text);
    const YamlFile yaml(file);
    CameraIntrinsics size;
    size.width = width, size.height = height;
    return ReadLens(yaml, yaml.root(), size);
  }
  std::string Complaint(const std::string& text) {
    try {
      Read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  TempFolder folder_;
};

TEST_F(LensYamlTest, WhatIsWrittenIsReadBack) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    const LensInFile lens = LensForFile(k);
    const CameraIntrinsics back =
        Read("camera_model: " + lens.camera_model + "\nintrinsics: " + ListOf(lens.intrinsics) +
                 "\ndistortion_model: " + lens.distortion_model +
                 "\ndistortion_coeffs: " + ListOf(lens.coefficients) + "\n",
             k.width,
             k.height)
            .intrinsics();
    EXPECT_EQ(back.distortion, k.distortion) << lens.camera_model;
    EXPECT_EQ(back.coefficients, k.coefficients) << lens.camera_model;
    EXPECT_EQ(back.fx, k.fx);
    EXPECT_EQ(back.cy, k.cy);
  }
}

TEST_F(LensYamlTest, KalibrsOrderOfIntrinsics) {
  const CameraIntrinsics omni =
      Read(
          "camera_model: omni\nintrinsics: [1.7, 905, 903, 320, 240]\n"
          "distortion_model: radtan\ndistortion_coeffs: [-0.1, 0.05, 0.001, 0.002]\n")
          .intrinsics();
  EXPECT_EQ(omni.distortion, DistortionModel::kUnified);
  EXPECT_EQ(omni.fx, 905);
  EXPECT_EQ(omni.coefficients[0], -0.1);
  EXPECT_EQ(omni.coefficients[4], 1.7);
  const CameraIntrinsics sphere =
      Read("camera_model: ds\nintrinsics: [-0.2, 0.6, 250, 251, 320, 240]\n").intrinsics();
  EXPECT_EQ(sphere.distortion, DistortionModel::kDoubleSphere);
  EXPECT_EQ(sphere.coefficients[0], -0.2);
  EXPECT_EQ(sphere.coefficients[1], 0.6);
  EXPECT_EQ(sphere.fy, 251);
}

TEST_F(LensYamlTest, OpenCvsListsOfCoefficients) {
  const auto with = [&](const char* list) {
    return Read(std::string("camera_model: pinhole\nintrinsics: [500, 500, 320, 240]\n"
                            "distortion_model: radtan\ndistortion_coeffs: ") +
                list + "\n")
        .intrinsics();
  };
  EXPECT_EQ(with("[-0.1, 0.05, 0, 0, 0]").distortion, DistortionModel::kRadialTangential);
  const CameraIntrinsics five = with("[-0.1, 0.05, 0, 0, -0.01]");
  EXPECT_EQ(five.distortion, DistortionModel::kRational);
  EXPECT_EQ(five.coefficients[4], -0.01);
  EXPECT_EQ(with("[-0.1, 0.05, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]").distortion,
            DistortionModel::kRadialTangential);
  EXPECT_EQ(with("[-0.1, 0.05, 0, 0, 0, 0.1, 0, 0]").coefficients[5], 0.1);
}

TEST_F(LensYamlTest, SaysWhatIsWrongAndWhere) {
  const std::string pinhole = "camera_model: pinhole\nintrinsics: [500, 500, 320, 240]\n";
  EXPECT_THAT(Complaint("camera_model: ds\nintrinsics: [500, 500, 320, 240]\n"),
              AllOf(HasSubstr("camera.yaml:2"), HasSubstr("[xi, alpha, fu, fv, cu, cv]")));
  EXPECT_THAT(Complaint("camera_model: ds\nintrinsics: [-2, 0.6, 250, 251, 320, 240]\n"),
              AllOf(HasSubstr("camera.yaml:2"), HasSubstr("xi of a double sphere")));
  EXPECT_THAT(Complaint("camera_model: eucm\nintrinsics: [0.6, 1, 250, 251, 320, 240]\n"
                        "distortion_model: radtan\ndistortion_coeffs: [0.1, 0, 0, 0]\n"),
              AllOf(HasSubstr("camera.yaml:3"), HasSubstr("no distortion besides")));
  EXPECT_THAT(Complaint("camera_model: omni\nintrinsics: [1.6, 900, 900, 320, 240]\n"
                        "distortion_model: equidistant\ndistortion_coeffs: [0.1, 0, 0, 0]\n"),
              AllOf(HasSubstr("camera.yaml:3"), HasSubstr("radtan or none")));
  EXPECT_THAT(Complaint(pinhole + "distortion_model: radtan\n"
                                  "distortion_coeffs: [0.1, 0, 0, 0, 0, 0, 0, 0, 0.2, 0, 0, 0]\n"),
              AllOf(HasSubstr("camera.yaml:4"), HasSubstr("4, 5 or 8 are expected")));
  EXPECT_THAT(Complaint(pinhole + "distortion_model: fov\ndistortion_coeffs: [4]\n"),
              AllOf(HasSubstr("camera.yaml:4"), HasSubstr("field of view")));
}

}  // namespace
}  // namespace facet
