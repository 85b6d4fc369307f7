// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/plane_error.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

constexpr double kRadPerDeg = std::numbers::pi / 180;
const Vector3d kBoardCentre(2.96, 0, 1);

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

// All are compared with all, so lists have to be of a size that a run can have.
TEST(PlaneErrorTest, ManyPlanesTakeNoHoursAndNoGigabytes) {
  std::vector<EstimatedPlane> planes;
  std::vector<TruePlane> truth;
  for (int i = 0; i < 3000; ++i) {
    planes.push_back(Estimate({0, 0, 1}, {0, 0, 1e-6 * i}));
    truth.push_back(True({1e-4 * i, 1, 1}, i, 1));
  }
  EXPECT_EQ(EvaluatePlanes(planes, truth, {}).num_matched, 0);
  const std::vector<TruePlane> same(truth.size(), True({0, 0, 1}, 0, 1));
  try {
    EvaluatePlanes(planes, same, {});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("must hold each plane once"));
  }
}

TEST(PlaneErrorTest, ListsOfMoreThanAnyRunHasAreRefused) {
  const TempFolder folder;
  std::string text = "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first,last,landmarks,area_m2\n";
  for (int i = 0; i <= 20'000; ++i)
    text += std::to_string(i) + ",0,0,1,0,0,0,0,horizontal,,1,2,10,1\n";
  WriteText(folder / "planes.csv", text);
  try {
    ReadEstimatedPlanes(folder / "planes.csv");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("planes.csv:20002: more than 20000 planes"));
  }
}

// A plane between a wall and the board that leans on it.
TEST(PlaneErrorTest, WhatIsRoughlyThereIsNotClose) {
  const std::vector<TruePlane> truth = {True({1, 0, 0}, 3, 6)};
  const auto recall = [&](double angle_deg, double offset_m, const PlaneErrorOptions& limits) {
    const double angle = angle_deg * kRadPerDeg;
    const Vector3d n(std::cos(angle), 0, std::sin(angle));
    return *EvaluatePlanes(std::vector{Estimate(n, {3 - offset_m, 0, 1})}, truth, {}, limits)
                .recall;
  };
  EXPECT_EQ(recall(9, 0.01, {}), 1);
  EXPECT_EQ(recall(9, 0.01, kClosePlanes), 0);
  EXPECT_EQ(recall(1, 0.09, {}), 1);
  EXPECT_EQ(recall(1, 0.09, kClosePlanes), 0);
  EXPECT_EQ(recall(2.9, 0.049, kClosePlanes), 1);
}

TEST(PlaneErrorTest, LimitsThatGrowWithTheDistanceFromThePath) {
  const std::vector<TruePlane> wall = {True({1, 0, 0}, 20, 30)};
  const auto recall = [&](double offset_m, const std::vector<Vector3d>& path_G) {
    const std::vector<EstimatedPlane> planes = {Estimate({1, 0, 0}, {20 + offset_m, 0, 0})};
    return *EvaluatePlanes(planes, wall, {}, kClosePlanesByDistance, path_G).recall;
  };
  const std::vector<Vector3d> far_and_near = {{0, 0, 0}, {5, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(recall(0.29, far_and_near), 1);  // 2 % of 15 m
  EXPECT_EQ(recall(0.31, far_and_near), 0);
  EXPECT_EQ(recall(0.31, {{0, 0, 0}}), 1);  // 2 % of 20 m
  EXPECT_EQ(recall(0.29, {}), 0);           // no path
  TrajectoryAlignment twice;
  twice.scale = 2;
  const std::vector<EstimatedPlane> half = {Estimate({1, 0, 0}, {10.14, 0, 0})};
  const std::vector<Vector3d> from{{5, 0, 0}};  // in the size of the truth
  EXPECT_EQ(EvaluatePlanes(half, wall, twice, kClosePlanesByDistance, from).num_matched, 1);
  EXPECT_EQ(EvaluatePlanes({{Estimate({1, 0, 0}, {20.31, 0, 0})}}, wall, {}, kClosePlanes).recall,
            0);
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
  const double tilt = 2 * kRadPerDeg;
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

// A wall with a poster on it and a board that leans at it by 6 deg.
std::vector<TruePlane> WallWithPosterAndBoard() {
  const double lean = 6 * kRadPerDeg;
  const Vector3d board(std::cos(lean), 0, std::sin(lean));
  return {True({1, 0, 0}, 3, 15, 20),
          True({1, 0, 0}, 2.994, 2.5),
          True(board, board.dot(kBoardCentre), 2.5)};
}

TEST(PlaneErrorTest, ALeaningBoardKeepsItsEstimateBesideAWall) {
  const std::vector<TruePlane> truth = WallWithPosterAndBoard();
  const EstimatedPlane board = Estimate(truth[2].n_G, kBoardCentre, 2);
  const PlaneError alone = EvaluatePlanes(std::vector{board}, truth, {});
  EXPECT_EQ(alone.num_true, 2);
  EXPECT_DOUBLE_EQ(*alone.recall, 2.5 / 20);
  EXPECT_NEAR(*alone.normal_error_deg_median, 0, 1e-9);
  const PlaneError both =
      EvaluatePlanes(std::vector{board, Estimate({1, 0, 0}, {3.08, 0, 1}, 10)}, truth, {});
  EXPECT_DOUBLE_EQ(*both.recall, 1);
  EXPECT_EQ(both.num_matched, 2);
  EXPECT_EQ(both.num_duplicates, 0);
}

TEST(PlaneErrorTest, ThePosterIsTheWall) {
  std::vector<TruePlane> truth = WallWithPosterAndBoard();
  truth.pop_back();
  const std::vector<EstimatedPlane> planes = {Estimate({1, 0, 0}, {3.001, 0, 1}, 10),
                                              Estimate({1, 0, 0}, {2.99, 2, 1}, 2)};
  const PlaneError error = EvaluatePlanes(planes, truth, {});
  EXPECT_EQ(error.num_true, 1);
  EXPECT_DOUBLE_EQ(*error.recall, 1);
  EXPECT_EQ(error.num_matched, 1);
  EXPECT_EQ(error.num_duplicates, 1);
  EXPECT_DOUBLE_EQ(*error.precision, 1);
}

TEST(PlaneErrorTest, FloorAndCarpetAreOneSurface) {
  // The carpet stands before the floor in the list and alone would be too small for the estimate.
  const std::vector<TruePlane> truth = {True({0, 0, 1}, 0.01, 2), True({0, 0, 1}, 0, 8, 10)};
  const PlaneError on_carpet =
      EvaluatePlanes(std::vector{Estimate({0, 0, 1}, {1, 1, 0.012}, 9)}, truth, {});
  EXPECT_EQ(on_carpet.num_true, 1);
  EXPECT_DOUBLE_EQ(*on_carpet.recall, 1);
  EXPECT_NEAR(*on_carpet.offset_error_m_median, 0.002, 1e-12);
  const PlaneError above =
      EvaluatePlanes(std::vector{Estimate({0, 0, 1}, {1, 1, 0.105}, 9)}, truth, {});
  EXPECT_EQ(above.num_matched, 1);
  const PlaneError too_large =
      EvaluatePlanes(std::vector{Estimate({0, 0, 1}, {1, 1, 0}, 41)}, truth, {});
  EXPECT_EQ(too_large.num_matched, 0);
}

TEST(PlaneErrorTest, TheUnseenBackOfABoardTakesNoEstimate) {
  // Nearer to the back than to the front.
  const std::vector<TruePlane> board = {True({1, 0, 0}, 1, 2), True({-1, 0, 0}, -0.97, 0.001, 2)};
  const EstimatedPlane behind = Estimate({1, 0, 0}, {0.98, 0, 1});
  EXPECT_DOUBLE_EQ(*EvaluatePlanes(std::vector{behind}, board, {}).recall, 1);
  const PlaneError both =
      EvaluatePlanes(std::vector{behind, Estimate({1, 0, 0}, {1, 0, 1})}, board, {});
  EXPECT_EQ(both.num_matched, 1);
  EXPECT_EQ(both.num_duplicates, 1);
}

TEST(PlaneErrorTest, OnlyWhatLiesFlatOnALargerPlaneIsPartOfIt) {
  const auto count = [](const TruePlane& other) {
    return EvaluatePlanes({}, std::vector{True({0, 0, 1}, 0, 16), other}, {}).num_true;
  };
  const double tilt = 0.2 * kRadPerDeg;
  EXPECT_EQ(count(True({0, 0, 1}, 0.019, 4)), 1);
  EXPECT_EQ(count(True({0, 0, 1}, -0.019, 4)), 1);
  EXPECT_EQ(count(True({0, 0, 1}, 0.021, 4)), 2);
  EXPECT_EQ(count(True({0, 0, 1}, 0, 4.1)), 2) << "too large to be sure that it lies on the other";
  EXPECT_EQ(count(True({0, 0, -1}, 0, 4)), 2) << "faces the other way";
  EXPECT_EQ(count(True({std::sin(tilt), 0, std::cos(tilt)}, 0, 4)), 2);
  const std::vector<TruePlane> pile = {
      True({0, 0, 1}, 0, 64), True({0, 0, 1}, 0.015, 8), True({0, 0, 1}, 0.03, 2)};
  EXPECT_EQ(EvaluatePlanes({}, pile, {}).num_true, 2) << "measured from the largest";
}

TEST(PlaneErrorTest, TwoTablesOfEqualHeightAreTwo) {
  const std::vector<TruePlane> tables = {True({0, 0, 1}, 0.7, 1.1, 1.2),
                                         True({0, 0, 1}, 0.7, 1.4, 1.5)};
  const EstimatedPlane table = Estimate({0, 0, 1}, {0, 0, 0.71}, 1);
  const PlaneError both =
      EvaluatePlanes(std::vector{table, Estimate({0, 0, 1}, {3, 0, 0.69}, 1)}, tables, {});
  EXPECT_EQ(both.num_true, 2);
  EXPECT_EQ(both.num_matched, 2);
  EXPECT_EQ(both.num_duplicates, 0);
  const PlaneError tie = EvaluatePlanes(std::vector{table}, tables, {});
  EXPECT_DOUBLE_EQ(*tie.recall, 1.4 / 2.5) << "the one seen more";
}

TEST(PlaneErrorTest, EqualScoresAreDecidedBySeenAreaAndThenByOrder) {
  // One plane halfway between two shelves, which are equally good for it.
  const std::vector<TruePlane> shelves = {
      True({0, 0, 1}, 0.5, 2), True({0, 0, 1}, 0.625, 3), True({0, 0, 1}, 0.5, 2)};
  const PlaneError between =
      EvaluatePlanes(std::vector{Estimate({0, 0, 1}, {0, 0, 0.5625})}, shelves, {});
  EXPECT_DOUBLE_EQ(*between.recall, 3.0 / 7);
  // Two planes equally far from one shelf, of which the upper could be another one, too.
  const std::vector<TruePlane> two = {True({0, 0, 1}, 0.5, 2), True({0, 0, 1}, 0.65, 2)};
  const EstimatedPlane below = Estimate({0, 0, 1}, {0, 0, 0.4375});
  const EstimatedPlane above = Estimate({0, 0, 1}, {0, 0, 0.5625});
  EXPECT_EQ(EvaluatePlanes(std::vector{below, above}, two, {}).num_matched, 2);
  const PlaneError upper_first = EvaluatePlanes(std::vector{above, below}, two, {});
  EXPECT_EQ(upper_first.num_matched, 1);
  EXPECT_EQ(upper_first.num_duplicates, 1);
}

TEST(PlaneErrorTest, RecallCountsLargePlanesOfWhichEnoughWasSeen) {
  const auto counts = [](const std::vector<TruePlane>& truth) {
    return EvaluatePlanes({}, truth, {}).num_true == 1;
  };
  EXPECT_FALSE(counts({True({0, 0, 1}, 0, 1, 1)}));
  EXPECT_TRUE(counts({True({0, 0, 1}, 0, 1, 1.01)}));
  EXPECT_FALSE(counts({True({0, 0, 1}, 0, 0.99, 5)}));
  const TruePlane hidden = True({0, 0, 1}, 0, 0.75, 1.1);
  EXPECT_TRUE(counts({hidden, True({0, 0, 1}, 0.001, 0.25)})) << "what hides it was seen";
  EXPECT_FALSE(counts({True({0, 0, 1}, 0, 0.9), True({0, 0, 1}, 0.001, 0.2)}))
      << "areas of what lies on a plane are part of its own";
}

TEST(PlaneErrorTest, SurfacesTooSmallForTheRecallAreNotPhantoms) {
  const std::vector<TruePlane> truth = {True({0, 0, 1}, 0, 10), True({0, 1, 0}, 1, 0.4)};
  const PlaneError error =
      EvaluatePlanes(std::vector{Estimate({0, 1, 0}, {0, 1, 0}, 0.3)}, truth, {});
  EXPECT_EQ(*error.recall, 0);
  EXPECT_EQ(error.num_true, 1);
  EXPECT_EQ(error.num_matched, 1);
  EXPECT_EQ(*error.precision, 1);
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

TEST(PlanesFileTest, AnIdIsAnInteger) {
  const TempFolder folder;
  for (const std::string id : {"1e42", "1.5", "", "x", "99999999999999999999"}) {
    WriteText(folder / "planes.csv", "id,nx,ny,nz,d\n" + id + ",0,0,1,0.5,1,2,0.5,,,,,,2\n");
    EXPECT_THROW(ReadEstimatedPlanes(folder / "planes.csv"), InputError) << id;
  }
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
