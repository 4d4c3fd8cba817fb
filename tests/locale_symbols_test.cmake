# cmake -D ARCHIVE=libtagcal.a -D NM=nm -D LIBRARY=lib -P locale_symbols_test.cmake
# Nothing in the library reads or writes numbers by functions that obey the locale of the program,
# which may have decimal commas: from_chars, to_chars, fmt and internal/text.hpp do not. The linker
# shows what sources hide: std::to_string of a double calls vsnprintf.
cmake_minimum_required(VERSION 3.23)

set(refused "^(__)?(isoc[0-9]+_)?(vsnprintf|vsprintf|sprintf|strto[dfl]+d?|atof|v?[fs]?scanf)(_chk)?$|basic_o?stringstream|basic_ostringstream")
# libtiff's own messages, of names and whole numbers.
set(allowed tiff_memory)

execute_process(COMMAND ${NM} --undefined-only --print-file-name ${ARCHIVE}
                OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
list(LENGTH symbols count)
if(count LESS 1000)
  message(FATAL_ERROR "${ARCHIVE}: only ${count} undefined symbols; is it the library?")
endif()
foreach(line IN LISTS symbols)
  string(REGEX REPLACE ".* [Uvw] " "" symbol "${line}")
  if(symbol MATCHES "${refused}" AND NOT line MATCHES "${allowed}")
    message(SEND_ERROR "obeys the locale: ${line}")
  endif()
endforeach()

# fmt refers to snprintf, for numbers that the library does not have, so the sources are searched.
file(GLOB_RECURSE sources ${LIBRARY}/tagcal/*.[ch]pp ${LIBRARY}/python/*.[ch]pp)
foreach(source IN LISTS sources)
  file(STRINGS ${source} lines REGEX "[^a-z_](sn?printf|strto[df]|atof|sto[df]|sscanf) *\\(|{:[0-9.+]*L|stringstream [a-z]")
  foreach(line IN LISTS lines)
    if(NOT source MATCHES "yaml_parser.cpp$")  # gives characters to yaml-cpp, which makes no numbers
      message(SEND_ERROR "obeys the locale: ${source}: ${line}")
    endif()
  endforeach()
endforeach()
