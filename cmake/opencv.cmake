# SPDX-License-Identifier: BSD-2-Clause
# Target facet_opencv: OpenCV's core, imgproc and features2d and nothing else.
# Debian ships OpenCVConfig.cmake only with libopencv-dev, which pulls in every module and their
# dependencies; the three -dev packages alone are enough, so headers and libraries are looked up here.

find_path(FACET_OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(facet_opencv INTERFACE)
target_include_directories(facet_opencv SYSTEM INTERFACE ${FACET_OPENCV_INCLUDE_DIR})
foreach(module core imgproc features2d)
  find_library(FACET_OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(facet_opencv INTERFACE ${FACET_OPENCV_${module}})
endforeach()
