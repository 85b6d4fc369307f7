# SPDX-License-Identifier: BSD-2-Clause
# cmake -D source_dir=... -D build_dir=... -D generator=... -D compiler=... -P package_test.cmake
# What is installed is enough to build and run the examples, and knows nothing of where it was built.

set(work ${build_dir}/package_test)
set(prefix ${work}/prefix)
file(REMOVE_RECURSE ${work})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${build_dir} --prefix ${prefix})
foreach(file bin/facet share/facet/config/euroc.yaml include/facet/pipeline/vio_pipeline.h include/facet/facet.h
    include/facet/io/calibration_file.h)
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
  if(file MATCHES "/(test|synthetic)_|/testing/|gtest")
    message(FATAL_ERROR "${file} belongs to the tests")
  endif()
endforeach()

foreach(example "library;at_rest" "shared_library;fly" "live_loop;live_loop")
  list(GET example 0 folder)
  list(GET example 1 program)
  run(${CMAKE_COMMAND} -S ${source_dir}/examples/${folder} -B ${work}/${folder} -G ${generator}
    -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=Release -D CMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --build ${work}/${folder})
  run(${work}/${folder}/${program})
endforeach()

# The same with pkg-config.
file(GLOB_RECURSE pc ${prefix}/*/facet.pc)
get_filename_component(pc_folder ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
foreach(part cflags libs)
  execute_process(COMMAND pkg-config --${part} facet
    OUTPUT_VARIABLE ${part} OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(${part} UNIX_COMMAND "${${part}}")
endforeach()
set(sources ${source_dir}/examples/shared_library)
run(${compiler} -std=c++17 -O1 ${cflags} ${sources}/tracker.cpp ${sources}/fly.cpp -o ${work}/fly ${libs})
run(${work}/fly)
