# Installs the build into a folder of its own and builds and runs a program against it that knows
# nothing else. Run as
#   cmake -D BUILD=<build tree> -D CONSUMER=<source>/tests/consumer -D SCRATCH=<folder>
#         -D COMPILER=<c++> -D FLAGS=<flags> -P consumer_test.cmake
cmake_minimum_required(VERSION 3.23)

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix ${SCRATCH}/prefix)
set(build ${SCRATCH}/build)
file(REMOVE_RECURSE ${SCRATCH})
run("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
# As wide as this compiler and this processor go: Eigen's alignment follows the flag.
set(options "")
if(EXISTS /proc/cpuinfo)
  file(STRINGS /proc/cpuinfo flags REGEX "^flags.* avx2 " LIMIT_COUNT 1)
  execute_process(COMMAND ${COMPILER} -mavx2 -E -x c++ /dev/null RESULT_VARIABLE unknown
                  OUTPUT_QUIET ERROR_QUIET)
  if(flags AND unknown EQUAL 0)
    set(options "-mavx2")
  endif()
endif()
run("configure" ${CMAKE_COMMAND} -G Ninja -S ${CONSUMER} -B ${build}
    -D CMAKE_PREFIX_PATH=${prefix} -D TAGCAL_INCLUDE=${prefix}/include
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${FLAGS} -D CONSUMER_OPTIONS=${options})
run("build" ${CMAKE_COMMAND} --build ${build} -j 2)
run("program" ${build}/tag_pose)
# The pixels were made from a tag at (0.02, -0.03, 0.55) m.
if(NOT output MATCHES "tag in camera \\[m\\]: +(0\\.0[0-9]+) +(-0\\.0[0-9]+) +(0\\.5[0-9]+)")
  message(FATAL_ERROR "program: unexpected output: ${output}")
endif()
set(x ${CMAKE_MATCH_1})
set(y ${CMAKE_MATCH_2})
set(z ${CMAKE_MATCH_3})
if(x LESS 0.019 OR x GREATER 0.021 OR y LESS -0.031 OR y GREATER -0.029 OR z LESS 0.54 OR
   z GREATER 0.56)
  message(FATAL_ERROR "program: the tag must be at (0.02, -0.03, 0.55) m, got ${output}")
endif()
run("program of other flags" ${build}/calibrate_desk ${CONSUMER}/../../data-synthetic/golden/desk)
if(NOT output MATCHES "fx [0-9]")
  message(FATAL_ERROR "calibrate_desk: unexpected output: ${output}")
endif()
if(options)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} --target without_target
                  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(result EQUAL 0 OR NOT output MATCHES "link the CMake target tagcal::tagcal")
    message(FATAL_ERROR "headers without the target must be refused under ${options}: ${output}")
  endif()
endif()
file(READ ${CONSUMER}/../../README.md readme)
file(READ ${CONSUMER}/tag_pose.cpp program)
string(REGEX REPLACE "^//[^\n]*\n" "" program "${program}")
string(FIND "${readme}" "${program}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "README.md does not show the program of tests/consumer/tag_pose.cpp")
endif()
file(REMOVE_RECURSE ${SCRATCH})
