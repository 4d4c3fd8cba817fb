# Every public header says in one #error that it needs C++20. Run as
#   cmake -D LIBRARY=<source>/lib -D INCLUDE=<build>/include -D COMPILER=<c++> -D EIGEN=<folder>
#         -P language_test.cmake
cmake_minimum_required(VERSION 3.23)
file(GLOB headers ${LIBRARY}/tagcal/*.hpp ${LIBRARY}/tagcal/*/*.hpp)
list(FILTER headers EXCLUDE REGEX "/internal/")
list(LENGTH headers count)
if(count LESS 50)
  message(FATAL_ERROR "${LIBRARY}: no public headers found")
endif()
foreach(header IN LISTS headers)
  # Preprocessed only: fast, and the same #error.
  execute_process(COMMAND ${COMPILER} -std=c++17 -DEIGEN_MAX_ALIGN_BYTES=16 -I ${LIBRARY} -I ${INCLUDE}
                          -isystem ${EIGEN} -E -x c++ ${header} OUTPUT_QUIET ERROR_VARIABLE errors)
  string(REGEX MATCHALL ": error: #error" found "${errors}")
  list(LENGTH found num_errors)
  if(NOT num_errors EQUAL 1 OR NOT errors MATCHES "tagcal needs C\\+\\+20: compile with -std=c\\+\\+20")
    message(FATAL_ERROR "${header}: must give one #error under C++17, got: ${errors}")
  endif()
endforeach()
