# SPDX-License-Identifier: BSD-2-Clause
# cmake -D source_dir=... -D build_dir=... -D generator=... -D compiler=... -P package_test.cmake
# What is installed is enough to build and run examples/library, and knows nothing of where it was built.

set(work ${build_dir}/package_test)
set(prefix ${work}/prefix)
file(REMOVE_RECURSE ${work})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${build_dir} --prefix ${prefix})
foreach(file bin/facet share/facet/config/euroc.yaml include/facet/pipeline/vio_pipeline.h)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
file(GLOB_RECURSE texts ${prefix}/*.cmake ${prefix}/*.h)
foreach(file ${texts})
  file(READ ${file} text)
  string(FIND "${text}" "${source_dir}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${file} names the folder of the sources, ${source_dir}")
  endif()
  if(file MATCHES "/(test|synthetic)_")
    message(FATAL_ERROR "${file} belongs to the tests")
  endif()
endforeach()

run(${CMAKE_COMMAND} -S ${source_dir}/examples/library -B ${work}/build -G ${generator}
  -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=Release -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/at_rest)
