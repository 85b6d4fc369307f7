# SPDX-License-Identifier: BSD-2-Clause
# Target facet::opencv: OpenCV's core, imgproc and features2d and nothing else. Installed, too: whoever
# links Facet looks them up again.
# Debian ships OpenCVConfig.cmake only with libopencv-dev, which pulls in every module and their
# dependencies; the three -dev packages alone are enough, so headers and libraries are looked up here.

if(TARGET facet::opencv)
  return()
endif()
find_path(FACET_OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(facet::opencv INTERFACE IMPORTED)
target_include_directories(facet::opencv SYSTEM INTERFACE ${FACET_OPENCV_INCLUDE_DIR})
foreach(module core imgproc features2d)
  find_library(FACET_OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(facet::opencv INTERFACE ${FACET_OPENCV_${module}})
endforeach()
