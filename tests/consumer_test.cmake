# Installs the build into a folder of its own, builds the programs of tests/consumer against it, runs
# them, and checks that the pages show them as they are. Run as
#   cmake -D BUILD=<build tree> -D CONSUMER=<source>/tests/consumer -D SCRATCH=<folder>
#         -D COMPILER=<c++> -D FLAGS=<flags> -P consumer_test.cmake
cmake_minimum_required(VERSION 3.23)

function(run what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${build} RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The page shows this text.
function(check_shown page text)
  file(READ ${source}/${page} shown)
  string(FIND "${shown}" "${text}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "${page} does not show:\n${text}")
  endif()
endfunction()

# check_program(NAME PAGE EXPECTED ARGUMENT...): the program prints what EXPECTED matches, and PAGE
# shows its text, but for the comment in its first line. match_1 to match_3 are the groups of EXPECTED.
function(check_program name page expected)
  run("${name}" ${build}/${name} ${ARGN})
  if(NOT output MATCHES "${expected}")
    message(FATAL_ERROR "${name}: unexpected output: ${output}")
  endif()
  foreach(group RANGE 1 3)
    set(match_${group} "${CMAKE_MATCH_${group}}" PARENT_SCOPE)
  endforeach()
  set(output "${output}" PARENT_SCOPE)
  file(READ ${CONSUMER}/${name}.cpp program)
  string(REGEX REPLACE "^//[^\n]*\n" "" program "${program}")
  check_shown(${page} "${program}")
endfunction()

set(prefix ${SCRATCH}/prefix)
set(build ${SCRATCH}/build)
cmake_path(SET source NORMALIZE ${CONSUMER}/../..)
set(golden ${source}/data-synthetic/golden/desk)
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${build})
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
find_program(READELF readelf)
if(READELF)
  run("readelf" ${READELF} -d ${build}/calibrate)
  if(output MATCHES "gflags|metis|atlas|f77blas")
    message(FATAL_ERROR "a program that links tagcal needs libraries of Ceres: ${output}")
  endif()
endif()

set(number "([-0-9.e]+)")
check_program(tag_pose README.md "tag in camera \\[m\\]: +${number} +${number} +${number}")
# The pixels were made from a tag at (0.02, -0.03, 0.55) m.
if(match_1 LESS 0.019 OR match_1 GREATER 0.021 OR match_2 LESS -0.031 OR match_2 GREATER -0.029 OR
   match_3 LESS 0.54 OR match_3 GREATER 0.56)
  message(FATAL_ERROR "tag_pose: the tag must be at (0.02, -0.03, 0.55) m, got ${match_1} ${match_2} ${match_3}")
endif()
check_program(render docs/tasks/library.md "^48 corners, the first at 105\\.454 323\\.745\n$")
check_program(detect docs/tasks/library.md
              "^0:0 105\\.4[0-9]* 323\\.7[0-9]* sd 0\\.00[0-9]*\n.*\n11:3 ")
check_program(robot docs/tasks/library.md
              "^camera at 0\\.(199|2)[0-9]* -0\\.(199|2)[0-9]* 0\\.(399|4)[0-9]* m.*\ntag 0 at .*\ntag 11 at .*\ntagcal [0-9]+\\.[0-9]+\\.[0-9]+\n$")
check_program(calibrate docs/tasks/library.md "ok, opencv4\nfx 902\\.[0-9]* \\+- 0\\.0" ${golden})
check_program(project docs/tasks/library.md
              "^349\\.5 239\\.5, du/dtx 300, du/dfx 0\\.05\nno pixel: behind the camera\n$")
check_program(solvers docs/tasks/library.md
              "pnp ${number} rad off\n.*plane, unknown focal length ${number} rad")
if(match_1 GREATER 1e-7 OR match_2 GREATER 1e-7)
  message(FATAL_ERROR "solvers: exact rays, but rotations are ${match_1} and ${match_2} rad off")
endif()
check_program(viewing docs/tasks/library.md
              "lens (336[0-9. ]+)\nmatrices (336[0-9. ]+)\nhalf the size: f 300")
if(NOT match_1 STREQUAL match_2)
  message(FATAL_ERROR "viewing: lens and matrices must agree: ${match_1}, ${match_2}")
endif()
check_program(reproject docs/tasks/reproject.md
              "^f 580\\.[0-9]*, corner 200, seen 255\npixel 438\\.[0-9]* 298\\.[0-9]*, variances 0\\.375")
foreach(part IN ITEMS chain frames windows depth clip)
  check_program(viewing_${part} docs/course/viewing.md ".")
  check_shown(docs/course/viewing.md "```\n${output}```\n")
endforeach()
check_program(examine docs/tasks/library.md
              "seen 8[0-9.]+ %.*sd at 1 m 0\\.00.*off the truth by 0\\.00.*show the board.*OpenCV agrees"
              ${golden})
check_program(explain docs/tasks/library.md
              "[0-9]+ tags reported, [0-9]+ not\ntag [0-9]+ corner 0 at .*, blur (0\\.[67][0-9]*) px"
              ${source}/data-synthetic/scenes/desk.yaml)
run("program of other flags" ${build}/calibrate_desk ${golden})
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

# The shared library: its SONAME has the version up to the minor one, it gives no names but its own,
# and the programs print what they print with the static one.
file(GLOB_RECURSE shared ${prefix}/*/libtagcal.so)
if(shared)
  file(STRINGS ${source}/CMakeLists.txt version REGEX "^project\\(tagcal VERSION")
  string(REGEX MATCH "[0-9]+\\.[0-9]+" version "${version}")
  find_program(NM nm)
  if(READELF AND NM)
    run("readelf" ${READELF} -d ${build}/calibrate_shared)
    if(NOT output MATCHES "NEEDED[^\n]*\\[libtagcal\\.so\\.${version}\\]" OR output MATCHES "opencv|ceres|apriltag")
      message(FATAL_ERROR "calibrate_shared must need libtagcal.so.${version}, and not its libraries: ${output}")
    endif()
    run("nm" ${NM} --dynamic --defined-only --format=posix ${shared})
    string(REGEX REPLACE "(^|\n)_Z(N|NK|TIN|TSN|TVN)6tagcal[^\n]*" "" others "${output}")
    if(others MATCHES "[^\n]")
      message(FATAL_ERROR "${shared} gives programs other names than its own: ${others}")
    endif()
  endif()
  foreach(name IN ITEMS tag_pose calibrate detect viewing reproject calibrate_desk)
    run("${name}" ${build}/${name} ${golden})
    set(expected "${output}")
    run("${name}_shared" ${build}/${name}_shared ${golden})
    if(NOT output STREQUAL expected)
      message(FATAL_ERROR "${name}: with the shared library ${output}, with the static one ${expected}")
    endif()
  endforeach()
endif()

# The same programs by pkg-config, which knows nothing of CMake.
find_program(PKG_CONFIG pkg-config)
file(GLOB_RECURSE pc ${prefix}/*/tagcal.pc)
if(PKG_CONFIG)
  cmake_path(GET pc PARENT_PATH pc_folder)
  set(ENV{PKG_CONFIG_PATH} ${pc_folder})
  run("pkg-config" ${PKG_CONFIG} --cflags --libs tagcal)
  cmake_path(GET pc_folder PARENT_PATH lib_folder)
  set(ENV{LD_LIBRARY_PATH} ${lib_folder})
  separate_arguments(flags UNIX_COMMAND "${FLAGS} ${output}")
  list(FILTER flags EXCLUDE REGEX "[\r\n]")
  foreach(name IN ITEMS calibrate detect)
    run("${name} by pkg-config" ${COMPILER} -std=c++20 ${CONSUMER}/${name}.cpp -o ${build}/${name}_pc ${flags})
  endforeach()
  run("calibrate by pkg-config" ${build}/calibrate_pc ${golden})
endif()
file(GLOB_RECURSE license ${prefix}/*/LICENSE)
if(NOT license)
  message(FATAL_ERROR "the licence is not installed")
endif()
file(READ ${source}/docs/tasks/library.md page)
file(GLOB_RECURSE headers RELATIVE ${prefix}/include/tagcal ${prefix}/include/tagcal/*.hpp)
foreach(header IN LISTS headers)
  string(FIND "${page}" "`${header}`" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "docs/tasks/library.md does not name the public header ${header}")
  endif()
endforeach()
file(REMOVE_RECURSE ${SCRATCH})
