# SPDX-License-Identifier: BSD-2-Clause
# What `make install` puts where: the program with configuration and documents, and for C++ the libraries
# up to facet::pipeline with their headers and a CMake package.

include(CMakePackageConfigHelpers)
install(TARGETS facet)
install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/facet)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Facet)
foreach(module base geometry camera imu map frontend estimator mesh regularities pipeline)
  set_target_properties(facet_${module} PROPERTIES EXPORT_NAME ${module})
  install(TARGETS facet_${module} EXPORT FacetTargets DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY src/facet/${module} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/facet
    FILES_MATCHING PATTERN "*.h" REGEX "/(test|synthetic)_[^/]*$" EXCLUDE)
endforeach()
install(EXPORT FacetTargets NAMESPACE facet:: DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/FacetConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/FacetConfig.cmake cmake/opencv.cmake ${PROJECT_BINARY_DIR}/FacetConfigVersion.cmake
  DESTINATION ${package_dir})

# Installs to a folder of its own and builds and runs examples/library against that.
if(FACET_BUILD_TESTS AND NOT FACET_SANITIZE)
  add_test(NAME package_test COMMAND ${CMAKE_COMMAND}
    -D source_dir=${PROJECT_SOURCE_DIR} -D build_dir=${PROJECT_BINARY_DIR} -D generator=${CMAKE_GENERATOR}
    -D compiler=${CMAKE_CXX_COMPILER} -P ${PROJECT_SOURCE_DIR}/cmake/package_test.cmake)
  set_tests_properties(package_test PROPERTIES LABELS package TIMEOUT 900)
endif()
