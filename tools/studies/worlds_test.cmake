# Tests the program with three small worlds: a second run adds only what is missing, equal worlds have
# equal records, pieces merge, and the scene of a world is written. Run as
#   cmake -D WORLDS=<program> -D SCRATCH=<folder> -P worlds_test.cmake
cmake_minimum_required(VERSION 3.23)

function(worlds expected)
  execute_process(COMMAND ${WORLDS} ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0 OR NOT output MATCHES "${expected}")
    message(FATAL_ERROR "worlds ${ARGN} (${result}), not \"${expected}\":\n${output}")
  endif()
endfunction()

# Sets `variable` to a record without its processor times.
function(record_of index file variable)
  file(STRINGS ${file} lines REGEX "^1,${index},")
  list(LENGTH lines count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "${file} has ${count} records of world ${index}")
  endif()
  string(REGEX REPLACE "^1,${index},[^,]*,[^,]*,[^,]*," "" record "${lines}")
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
record_of(1 ${SCRATCH}/a.csv first)
record_of(1 ${SCRATCH}/b.csv second)
if(NOT first STREQUAL second)
  message(FATAL_ERROR "world 1 differs:\n${first}\n${second}")
endif()

worlds("worlds . 3 " merge ${SCRATCH}/a.csv ${SCRATCH}/b.csv --out ${SCRATCH}/all.csv
       --page ${SCRATCH}/page.md)
worlds("worlds . 3 " merge ${SCRATCH}/all.csv)
worlds("tagcal render .*--seed 2" scene --index 1 --out ${SCRATCH}/w1_1.yaml)
