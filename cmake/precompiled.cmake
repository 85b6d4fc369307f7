# SPDX-License-Identifier: BSD-2-Clause
# Headers that most sources include are compiled once: facet_use_precompiled(TARGET core|json|test). Every source and
# header names what it uses all the same and compiles without (-D FACET_PCH=OFF).

option(FACET_PCH "Precompile the headers that most sources include" ON)
# So that tests compile faster. What libraries have in their sources is optimised as always; inline
# functions that a test uses, too, may be the test's. With -O1, GCC 12 warns of optional values that are empty.
set(FACET_TEST_OPTIONS "$<$<CONFIG:Release>:-O1;$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>>")

# facet_precompile(core HEADERS ... LIBS ...): a target that other targets borrow the headers from. The headers are
# in <>, which CMake does not turn into absolute paths: a compiler cache then serves other clones, too.
function(facet_precompile NAME)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBS" ${ARGN})
  set(target facet_precompiled_${NAME})
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${target} PRIVATE facet_warnings Eigen3::Eigen ${ARG_LIBS})
  target_precompile_headers(${target} PRIVATE ${ARG_HEADERS})
endfunction()

function(facet_use_precompiled TARGET NAME)
  if(FACET_PCH)
    target_precompile_headers(${TARGET} REUSE_FROM facet_precompiled_${NAME})
  endif()
endfunction()

if(FACET_PCH)
  set(core_headers
    <algorithm> <array> <cmath> <cstdint> <cstdio> <deque> <filesystem> <fstream> <functional> <iostream> <limits> <map>
    <memory> <numbers> <numeric> <optional> <set> <span> <sstream> <string> <unordered_map> <utility> <vector>
    <Eigen/Dense> <facet/base/types.h>)
  facet_precompile(core HEADERS ${core_headers})
  facet_precompile(json HEADERS ${core_headers} <nlohmann/json.hpp> LIBS nlohmann_json::nlohmann_json)
  if(FACET_BUILD_TESTS)
    facet_precompile(test HEADERS ${core_headers} <gmock/gmock.h> <gtest/gtest.h> LIBS GTest::gtest GTest::gmock)
    target_compile_options(facet_precompiled_test PRIVATE ${FACET_TEST_OPTIONS})
  endif()
endif()
