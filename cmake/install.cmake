# SPDX-License-Identifier: BSD-2-Clause
# What `make install` puts where: the program with configuration and documents, and for C++ facet/facet.h
# (facet::facade), the libraries below it with their headers, a CMake package and a pkg-config file.

include(CMakePackageConfigHelpers)
install(TARGETS facet)
install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/facet)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Facet)
set(modules robot facade live messages io pipeline loop regularities mesh estimator plausibility frontend map imu calibration camera geometry base)
# What `make install` has to build.
add_custom_target(installable DEPENDS facet)
foreach(module ${modules})
  add_dependencies(installable facet_${module})
  set_target_properties(facet_${module} PROPERTIES EXPORT_NAME ${module})
  install(TARGETS facet_${module} EXPORT FacetTargets DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY src/facet/${module} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/facet
    FILES_MATCHING PATTERN "*.h")
  get_target_property(type facet_${module} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    string(APPEND FACET_PC_LIBS "-lfacet_${module} ")
  endif()
endforeach()
install(FILES src/facet/facet.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/facet)
string(APPEND FACET_PC_LIBS
  "-lopencv_features2d -lopencv_imgproc -lopencv_core -lyaml-cpp -lpng -ljpeg -lwebp -lz -pthread")
if(DEFLATE_FOUND)
  string(APPEND FACET_PC_LIBS " -ldeflate")
endif()
file(RELATIVE_PATH FACET_PC_UP "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file(cmake/facet.pc.in facet.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/facet.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(EXPORT FacetTargets NAMESPACE facet:: DESTINATION ${package_dir})
# With these names both find_package(Facet) and find_package(facet) find it.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/facet-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/facet-config.cmake DESTINATION ${package_dir})
install(FILES cmake/opencv.cmake ${PROJECT_BINARY_DIR}/facet-config-version.cmake DESTINATION ${package_dir})

# Installs to a folder of its own and builds and runs examples/library against that.
if(FACET_BUILD_TESTS AND NOT FACET_SANITIZE)
  add_test(NAME package_test COMMAND ${CMAKE_COMMAND}
    -D source_dir=${PROJECT_SOURCE_DIR} -D build_dir=${PROJECT_BINARY_DIR} -D generator=${CMAKE_GENERATOR}
    -D compiler=${CMAKE_CXX_COMPILER} -P ${PROJECT_SOURCE_DIR}/cmake/package_test.cmake)
  set_tests_properties(package_test PROPERTIES LABELS package TIMEOUT 900)
endif()
