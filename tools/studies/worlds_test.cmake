# Tests the program with three small worlds of pixels and three of corners: a second run adds only
# what is missing, equal worlds have equal records, pieces merge, switches force defects, and a world
# is written as a scene or a data set. Run as
#   cmake -D STUDY=<program> -D SCRATCH=<folder> -P worlds_test.cmake
cmake_minimum_required(VERSION 3.23)

function(worlds expected)
  execute_process(COMMAND ${STUDY} worlds ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0 OR NOT output MATCHES "${expected}")
    message(FATAL_ERROR "worlds ${ARGN} (${result}), not \"${expected}\":\n${output}")
  endif()
endfunction()

function(worlds_fails expected)
  execute_process(COMMAND ${STUDY} worlds ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 2 OR NOT output MATCHES "${expected}")
    message(FATAL_ERROR "worlds ${ARGN} (${result}), not \"${expected}\":\n${output}")
  endif()
endfunction()

# Sets `variable` to a record without its processor times.
function(record_of index mode file variable)
  file(STRINGS ${file} lines REGEX "^${mode} 1,${index},1,")
  list(LENGTH lines count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "${file} has ${count} records of world ${index}")
  endif()
  string(REGEX REPLACE "^${mode} 1,${index},1,${mode},,[^,]*,[^,]*,[^,]*,[^,]*," "" record "${lines}")
  set(${variable} "${record}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH})
worlds("2 worlds added, 0 were there" run --first 0 --count 2 --out ${SCRATCH}/a.csv)
file(READ ${SCRATCH}/a.csv before)
worlds("0 worlds added, 2 were there" run --first 0 --count 2 --out ${SCRATCH}/a.csv)
file(READ ${SCRATCH}/a.csv after)
if(NOT before STREQUAL after)
  message(FATAL_ERROR "a run that has nothing to do changed its file")
endif()

# A world whose line was cut short is judged again.
string(REGEX REPLACE ".......\n$" "" cut "${before}")
file(WRITE ${SCRATCH}/a.csv "${cut}")
worlds("2 worlds added, 1 were there" run --first 0 --count 3 --out ${SCRATCH}/a.csv)
worlds("1 worlds added, 0 were there" run --first 1 --count 1 --threads 1 --out ${SCRATCH}/b.csv)
record_of(1 pixels ${SCRATCH}/a.csv first)
record_of(1 pixels ${SCRATCH}/b.csv second)
if(NOT first STREQUAL second)
  message(FATAL_ERROR "world 1 differs:\n${first}\n${second}")
endif()

worlds("worlds . 3 " merge ${SCRATCH}/a.csv ${SCRATCH}/b.csv --out ${SCRATCH}/all.csv
       --page ${SCRATCH}/page.md)
worlds("worlds . 3 " merge ${SCRATCH}/all.csv)
worlds("tagcal render .*--seed 2" scene --index 1 --out ${SCRATCH}/w1_1.yaml)

# Corners without pictures, in the same file.
worlds("3 worlds added, 0 were there" run --corners-only --count 3 --out ${SCRATCH}/a.csv)
worlds("1 worlds added, 0 were there" run --corners-only --first 1 --count 1 --threads 1 --out
       ${SCRATCH}/c.csv)
record_of(1 corners ${SCRATCH}/a.csv first)
record_of(1 corners ${SCRATCH}/c.csv second)
if(NOT first STREQUAL second)
  message(FATAL_ERROR "world 1 of corners differs:\n${first}\n${second}")
endif()
worlds("mode: pixels.*mode: corners" merge ${SCRATCH}/a.csv)
worlds("tagcal calibrate" scene --corners-only --index 1 --out ${SCRATCH}/c1_1)
if(NOT EXISTS ${SCRATCH}/c1_1/corners.csv)
  message(FATAL_ERROR "the data set of a world has no corners")
endif()

# Switches.
worlds("1 worlds added, 0 were there" run --corners-only --with rows,bend --without twist,aspect
       --count 1 --out ${SCRATCH}/c.csv)
file(STRINGS ${SCRATCH}/c.csv bent REGEX "^corners 1[+]bend[+]rows-aspect-twist,0,1,.*,bend[+]rows,")
if(NOT bent)
  message(FATAL_ERROR "no bent world with sheared rows in ${SCRATCH}/c.csv")
endif()
worlds("cp .*target.yaml" scene --index 1 --with bend --out ${SCRATCH}/w1_1b.yaml)
worlds("1 worlds added, 0 were there" run --with camera:webcam --index 3 --count 1 --out
       ${SCRATCH}/e.csv)
worlds("pictures.*webcam . 1 " merge ${SCRATCH}/e.csv)
# `scene` reads its file back.
foreach(kind clipped mosaic raw denoised sharpened jpeg webcam phone vignetting defocus rounded)
  worlds("tagcal render " scene --with camera:${kind} --index 1 --out ${SCRATCH}/${kind}.yaml)
endforeach()
file(STRINGS ${SCRATCH}/defocus.yaml focus REGEX "^sensor: .*focus: {distance_m: ")
if(NOT focus)
  message(FATAL_ERROR "no focus in ${SCRATCH}/defocus.yaml")
endif()
worlds_fails("unknown kind of pictures" run --with camera:painted --out ${SCRATCH}/d.csv)
worlds_fails("both have camera:jpeg" run --with camera:jpeg --without camera --out
             ${SCRATCH}/d.csv)
worlds_fails("worlds of pixels do not have it" run --with rows --out ${SCRATCH}/d.csv)
worlds_fails("unknown defect" run --with wind --out ${SCRATCH}/d.csv)
worlds_fails("both have bend" run --with bend --without bend --out ${SCRATCH}/d.csv)
