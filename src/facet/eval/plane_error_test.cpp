// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

TruePlane True(const Vector3d& n, double d, double seen_area, double area = 0) {
  return {n.normalized(), d, area > 0 ? area : seen_area, seen_area, ""};
}

EstimatedPlane Estimate(const Vector3d& n, const Vector3d& centre, double area = 1) {
  EstimatedPlane plane;
  plane.n_W = n.normalized();
  plane.centre_W = centre;
  plane.d_W = plane.n_W.dot(centre);
  plane.area_m2 = area;
  return plane;
}

// Floor 10 m2, wall 6 m2, table 4 m2, and a book that is too small to count.
std::vector<TruePlane> Room() {
  return {True({0, 0, 1}, 0, 10),
          True({1, 0, 0}, 3, 6),
          True({0, 0, 1}, 0.7, 4),
          True({0, 1, 0}, 1, 0.1)};
}

TEST(PlaneErrorTest, PerfectPlanes) {
  const std::vector<EstimatedPlane> planes = {Estimate({0, 0, -1}, {1, 1, 0}),
                                              Estimate({1, 0, 0}, {3, 0, 1}),
                                              Estimate({0, 0, 1}, {0, 2, 0.7})};
  const PlaneError error = EvaluatePlanes(planes, Room(), {});
  EXPECT_DOUBLE_EQ(*error.recall, 1);
  EXPECT_DOUBLE_EQ(*error.precision, 1);
  EXPECT_EQ(error.num_true, 3);
  EXPECT_EQ(error.num_matched, 3);
  EXPECT_EQ(error.num_duplicates, 0);
  EXPECT_NEAR(*error.normal_error_deg_median, 0, 1e-9);
  EXPECT_NEAR(*error.offset_error_m_median, 0, 1e-12);
}

TEST(PlaneErrorTest, RecallIsWeightedBySeenArea) {
  const std::vector<EstimatedPlane> planes = {Estimate({0, 0, 1}, {0, 0, 0})};
  EXPECT_DOUBLE_EQ(*EvaluatePlanes(planes, Room(), {}).recall, 0.5);
}

TEST(PlaneErrorTest, DuplicatesAreOnTheTruthAndPhantomsAreNot) {
  const std::vector<EstimatedPlane> planes = {Estimate({0, 0, 1}, {0, 0, 0.01}),
                                              Estimate({0, 0, 1}, {2, 0, -0.02}),
                                              Estimate({0, 0, 1}, {0, 0, 0.35}),
                                              Estimate({1, 1, 0}, {1, 1, 1})};
  const PlaneError error = EvaluatePlanes(planes, Room(), {});
  EXPECT_EQ(error.num_matched, 1);
  EXPECT_EQ(error.num_duplicates, 1);
  EXPECT_DOUBLE_EQ(*error.precision, 0.5);
  EXPECT_NEAR(*error.offset_error_m_median, 0.01, 1e-12);
}

TEST(PlaneErrorTest, ErrorsAreTakenAtTheSupport) {
  // Tilted by 2 deg and 3 cm too high at its support, which is 10 m away from the origin: the
  // distance at the origin would be off by a third of a metre.
  const double tilt = 2 * 3.14159265358979 / 180;
  const Vector3d n(std::sin(tilt), 0, std::cos(tilt));
  const std::vector<EstimatedPlane> planes = {Estimate(n, {10, 0, 0.03})};
  const PlaneError error = EvaluatePlanes(planes, Room(), {});
  EXPECT_NEAR(*error.normal_error_deg_median, 2, 1e-9);
  EXPECT_NEAR(*error.offset_error_m_median, 0.03, 1e-12);
}

TEST(PlaneErrorTest, IndependentOfTheWorldFrame) {
  TrajectoryAlignment alignment;
  alignment.T_GW = SE3(ExpSO3({0.1, -0.2, 1.1}), {3, -1, 2});
  const SE3 T_WG = alignment.T_GW.Inverse();
  std::vector<EstimatedPlane> planes;
  for (const auto& [n, c] : {std::pair<Vector3d, Vector3d>{{0, 0, 1}, {1, 1, 0.02}},
                             std::pair<Vector3d, Vector3d>{{1, 0, 0}, {3.02, 0, 1}}}) {
    planes.push_back(Estimate(T_WG.q * n, T_WG * c));
  }
  const PlaneError error = EvaluatePlanes(planes, Room(), alignment);
  EXPECT_DOUBLE_EQ(*error.recall, 0.8);
  EXPECT_NEAR(*error.normal_error_deg_median, 0, 1e-6);
  EXPECT_NEAR(*error.offset_error_m_median, 0.02, 1e-9);
}

TEST(PlaneErrorTest, ALargePlaneIsNotASmallThing) {
  const std::vector<TruePlane> book = {True({0, 1, 0}, 1, 0.05)};
  EXPECT_EQ(*EvaluatePlanes(std::vector{Estimate({0, 1, 0}, {0, 1, 0}, 5)}, book, {}).precision, 0);
  EXPECT_EQ(*EvaluatePlanes(std::vector{Estimate({0, 1, 0}, {0, 1, 0}, 0.1)}, book, {}).precision,
            1);
}

TEST(PlaneErrorTest, NothingFoundAndNothingToFind) {
  const PlaneError none = EvaluatePlanes({}, Room(), {});
  EXPECT_EQ(*none.recall, 0);
  EXPECT_FALSE(none.precision);
  EXPECT_FALSE(none.normal_error_deg_median);
}

TEST(PlanesFileTest, ReadsBothKinds) {
  const TempFolder folder;
  WriteText(
      folder / "planes.csv",
      "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2,"
      "sigma_normal_rad,sigma_d_m\n4,0,0,1,0.5,1,2,0.5,horizontal,floor,10,20,33,2.5,.01,.02\n");
  const auto estimated = ReadEstimatedPlanes(folder / "planes.csv");
  ASSERT_EQ(estimated.size(), 1u);
  EXPECT_EQ(estimated[0].id, 4);
  EXPECT_EQ(estimated[0].label, "floor");
  EXPECT_EQ(estimated[0].area_m2, 2.5);
  WriteText(folder / "truth.csv", "#plane,nx,ny,nz,d,area,seen,label\r\n0,0,0,1,0.5,4,3,floor\r\n");
  const auto truth = ReadTruePlanes(folder / "truth.csv");
  ASSERT_EQ(truth.size(), 1u);
  EXPECT_EQ(truth[0].seen_area_m2, 3);
  WriteText(folder / "empty.csv", "id,nx,ny,nz,d\n");
  EXPECT_TRUE(ReadEstimatedPlanes(folder / "empty.csv").empty());
  WriteText(folder / "none.csv",
            "#plane,nx,ny,nz,d [m] (n.x = d),area [m^2],seen area [m^2],label,seen_s [s]\r\n");
  EXPECT_TRUE(ReadTruePlanes(folder / "none.csv").empty());
}

TEST(PlanesFileTest, NamesFileAndLine) {
  const TempFolder folder;
  const auto message = [&](const std::string& text) {
    WriteText(folder / "t.csv", text);
    try {
      ReadTruePlanes(folder / "t.csv");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message("#plane,nx\n"), HasSubstr("t.csv:1: the truth holds no plane"));
  EXPECT_THAT(message(""), HasSubstr("t.csv:1: the truth holds no plane"));
  EXPECT_THAT(message("#plane,nx,ny,nz,d,ar"), HasSubstr("t.csv:1: the truth holds no plane"));
  EXPECT_THAT(message("#p\n0,0,0,1,0.5,4\n"),
              HasSubstr("t.csv:2: 6 columns; column 7 (seen area)"));
  EXPECT_THAT(message("0,0,0,2,0.5,4,3\n"), HasSubstr("t.csv:1: the normal has norm 2"));
  EXPECT_THAT(message("0,0,nan,1,0.5,4,3\n"), HasSubstr("t.csv:1: column 3 (ny) is 'nan'"));
}

}  // namespace
}  // namespace facet
