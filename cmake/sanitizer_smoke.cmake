# SPDX-License-Identifier: BSD-2-Clause
# A few sources and their tests under the address and undefined-behaviour sanitizers, on every `make test`; all of them
# in `make test-long`. They are compiled once more, because a library is sanitized as a whole or not at all.

if(NOT FACET_BUILD_TESTS OR FACET_SANITIZE)
  return()
endif()
set(root ${PROJECT_SOURCE_DIR}/src/facet)
file(GLOB smoke_sources ${root}/imu/*.cpp)
list(FILTER smoke_sources EXCLUDE REGEX imu_fuzz_test)  # has parts in testing/
add_executable(sanitizer_smoke_test ${smoke_sources} ${root}/geometry/delaunay.cpp ${root}/geometry/delaunay_test.cpp
  ${root}/geometry/plane.cpp ${root}/geometry/se3.cpp ${root}/geometry/so3.cpp)
set_target_properties(sanitizer_smoke_test PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
target_include_directories(sanitizer_smoke_test PRIVATE ${PROJECT_SOURCE_DIR}/src)
target_compile_features(sanitizer_smoke_test PRIVATE cxx_std_20)
target_compile_definitions(sanitizer_smoke_test PRIVATE EIGEN_INITIALIZE_MATRICES_BY_NAN)
set(sanitize -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=all)
target_compile_options(sanitizer_smoke_test PRIVATE -O1 ${sanitize})
target_link_options(sanitizer_smoke_test PRIVATE ${sanitize})
target_link_libraries(sanitizer_smoke_test PRIVATE Eigen3::Eigen GTest::gtest GTest::gtest_main)
add_test(NAME sanitizer_smoke COMMAND sanitizer_smoke_test)
set_tests_properties(sanitizer_smoke PROPERTIES LABELS unit TIMEOUT 300)
