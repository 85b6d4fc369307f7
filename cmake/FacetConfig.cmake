# SPDX-License-Identifier: BSD-2-Clause
# find_package(Facet) gives facet::pipeline and the libraries that it is made of.
# Compile what links them with the same -march as Facet itself: Eigen's alignment depends on it.

include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Eigen3 3.4 NO_MODULE)
include("${CMAKE_CURRENT_LIST_DIR}/opencv.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/FacetTargets.cmake")
