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
run("configure" ${CMAKE_COMMAND} -G Ninja -S ${CONSUMER} -B ${build}
    -D CMAKE_PREFIX_PATH=${prefix} -D TAGCAL_INCLUDE=${prefix}/include
    -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_FLAGS=${FLAGS})
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
file(READ ${CONSUMER}/../../README.md readme)
file(READ ${CONSUMER}/tag_pose.cpp program)
string(REGEX REPLACE "^//[^\n]*\n" "" program "${program}")
string(FIND "${readme}" "${program}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "README.md does not show the program of tests/consumer/tag_pose.cpp")
endif()
file(REMOVE_RECURSE ${SCRATCH})
