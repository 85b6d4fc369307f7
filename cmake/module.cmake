# SPDX-License-Identifier: BSD-2-Clause
# Three functions describe every folder of the project: facet_add_module, facet_add_test and facet_add_fuzzer.

add_library(facet_warnings INTERFACE)
target_compile_options(facet_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wold-style-cast
  -Woverloaded-virtual $<$<BOOL:${FACET_WERROR}>:-Werror>)
# GCC 12 reports std::string's own code where it is inlined from a precompiled header (its bugs 105329 and 105651).
target_compile_options(facet_warnings INTERFACE
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-stringop-overflow -Wno-array-bounds>)

# GCC collects its garbage from 128 MB on, again and again; from 512 MB on, builds take a tenth less time.
add_compile_options("$<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=524288>")

# Results must not depend on whether the compiler fuses a multiplication with an addition.
add_compile_options(-ffp-contract=off)
# A shared object may link the libraries. Everything is compiled alike, because precompiled headers serve libraries and
# programs; functions of a library still call each other directly.
add_compile_options(-fPIC -fno-semantic-interposition)
if(FACET_NATIVE)
  add_compile_options(-march=native)
endif()
if(FACET_SANITIZE)
  add_compile_options(-fsanitize=${FACET_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${FACET_SANITIZE})
endif()
if(FACET_FUZZER)
  add_compile_options(-fsanitize-coverage-ignorelist=${CMAKE_CURRENT_LIST_DIR}/fuzz_ignore.txt
                      -fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/fuzz_unchecked.txt)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  add_compile_definitions(EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()

# The compiler spends most of its time on Eigen's expressions, which sources of one folder share. So several of them are
# compiled together, and names in their unnamed namespaces must not clash. -D FACET_UNITY=OFF is faster where one source
# is edited again and again; results are the same.
option(FACET_UNITY "Compile several sources of tests and of large libraries together" ON)

# facet_add_module(NAME imu SRCS a.cpp ... DEPS geometry ... LIBS PNG::PNG ... [PCH json] [UNITY])
# A static library facet_<name> with alias facet::<name>; DEPS are other modules, LIBS are foreign targets; PCH is
# for facet_use_precompiled and 'core' by default; UNITY: sources are compiled together (FACET_UNITY).
function(facet_add_module)
  cmake_parse_arguments(ARG "UNITY" "NAME;PCH" "SRCS;DEPS;LIBS" ${ARGN})
  if(NOT ARG_PCH)
    set(ARG_PCH core)
  endif()
  set(target facet_${ARG_NAME})
  if(ARG_SRCS)
    add_library(${target} STATIC ${ARG_SRCS})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:facet_warnings>)
    facet_use_precompiled(${target} ${ARG_PCH})
    if(ARG_UNITY)
      set_target_properties(${target} PROPERTIES UNITY_BUILD ${FACET_UNITY} UNITY_BUILD_BATCH_SIZE 4)
    endif()
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(facet::${ARG_NAME} ALIAS ${target})
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} ${scope} cxx_std_20)
  foreach(dep ${ARG_DEPS})
    target_link_libraries(${target} ${scope} facet::${dep})
  endforeach()
  target_link_libraries(${target} ${scope} ${ARG_LIBS})
endfunction()

# facet_add_test(NAME geometry_test SRCS plane_fit_test.cpp ... DEPS geometry testing LIBS ... LABEL unit|sim|dataset)
# One program for the tests of a folder that need the same libraries. ctest runs each test as a process of its own,
# unless they are TOGETHER: those that share what takes long to prepare.
function(facet_add_test)
  if(NOT FACET_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "TOGETHER" "NAME;LABEL" "SRCS;DEPS;LIBS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  add_executable(${ARG_NAME} ${ARG_SRCS})
  set_target_properties(${ARG_NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_link_libraries(${ARG_NAME} PRIVATE facet_warnings GTest::gtest GTest::gmock GTest::gtest_main ${ARG_LIBS})
  foreach(dep ${ARG_DEPS})
    target_link_libraries(${ARG_NAME} PRIVATE facet::${dep})
  endforeach()
  if(NOT ARG_LABEL STREQUAL "speed")
    facet_use_precompiled(${ARG_NAME} test)
    target_compile_options(${ARG_NAME} PRIVATE ${FACET_TEST_OPTIONS})
  endif()
  set_target_properties(${ARG_NAME} PROPERTIES UNITY_BUILD ${FACET_UNITY} UNITY_BUILD_BATCH_SIZE 8)
  # Under sanitizers some tests take twenty times as long.
  if(FACET_SANITIZE)
    set(timeout_s 3600)
  else()
    set(timeout_s 900)
  endif()
  if(ARG_TOGETHER)
    add_test(NAME ${ARG_NAME} COMMAND ${ARG_NAME})
    set_tests_properties(${ARG_NAME} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${timeout_s} COST 100)  # long ones first
  else()
    gtest_discover_tests(${ARG_NAME} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${timeout_s})
  endif()
endfunction()

# facet_add_fuzzer(NAME imu_fuzzer DEPS imu_fuzz ...): the program of that name and source under libFuzzer, if FACET_FUZZER is on.
function(facet_add_fuzzer)
  if(NOT FACET_FUZZER)
    return()
  endif()
  cmake_parse_arguments(ARG "" "NAME" "DEPS" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_NAME}.cpp)
  target_link_libraries(${ARG_NAME} PRIVATE facet_warnings)
  target_link_options(${ARG_NAME} PRIVATE -fsanitize=fuzzer)
  foreach(dep ${ARG_DEPS})
    target_link_libraries(${ARG_NAME} PRIVATE facet::${dep})
  endforeach()
endfunction()
