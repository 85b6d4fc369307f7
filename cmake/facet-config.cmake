# SPDX-License-Identifier: BSD-2-Clause
# find_package(facet), or find_package(Facet), gives facet::facade (facet/facet.h: C++17, no other headers needed) and the libraries
# that it is made of, such as facet::pipeline. What includes headers of those must be compiled as C++20 and
# with the same -march as Facet itself: Eigen's alignment depends on it.

include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Eigen3 3.4 NO_MODULE)
find_dependency(yaml-cpp)
find_dependency(nlohmann_json)
find_dependency(PNG)
find_dependency(JPEG)
find_dependency(PkgConfig)
pkg_check_modules(WEBP REQUIRED IMPORTED_TARGET libwebp)
pkg_check_modules(DEFLATE IMPORTED_TARGET libdeflate)
include("${CMAKE_CURRENT_LIST_DIR}/opencv.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/FacetTargets.cmake")
