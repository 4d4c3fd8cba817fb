# cmake -D OBJECT=project_kernels_avx2.cpp.o -D NM=nm -P kernel_symbols_test.cmake
# A file of kernels compiled for AVX2 gives the linker its table and no function: an inline one of
# Eigen or the standard library in it could become the whole program's copy, which would then not run
# on a processor without it.
cmake_minimum_required(VERSION 3.23)

execute_process(COMMAND ${NM} --defined-only --extern-only ${OBJECT}
                OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n$" "" symbols "${symbols}")
string(REPLACE "\n" ";" symbols "${symbols}")
set(found FALSE)
foreach(symbol IN LISTS symbols)
  if(symbol MATCHES " [A-Z] _ZN6tagcal8internal(12kAvx2Kernels|15kAvx2TagKernels|21kAvx2ReprojectKernels)E$")
    set(found TRUE)
  elseif(symbol MATCHES " [TWui] ")  # code, weak code, unique, chosen at load
    message(FATAL_ERROR "${OBJECT}: must not define ${symbol}")
  endif()
endforeach()
if(NOT found)
  message(FATAL_ERROR "${OBJECT}: defines no kernels")
endif()
