# Renames Eigen's functions that a static library brings along. Run as
#   cmake -D ARCHIVE=<lib.a> -D NM=<nm> -D READELF=<readelf> -D OBJCOPY=<objcopy> -P own_eigen_code.cmake
# They are templates and inline functions, of which a linker keeps one copy for the whole program:
# that of a program built with -mavx2 would free, by Eigen's allocator for 32 bytes, what the
# library's allocator for 16 bytes made. Under names of its own the library keeps its own copy.
cmake_minimum_required(VERSION 3.23)

set(eigen "_Z(GV)?Z?NK?5Eigen[A-Za-z0-9_.]*")
execute_process(COMMAND ${NM} --defined-only ${ARCHIVE} OUTPUT_VARIABLE symbols ERROR_QUIET
                COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " [WVu] ${eigen}" weak "${symbols}")
list(TRANSFORM weak REPLACE "^ . " "")
# A copy is recognised by the name of its group, which for constructors is no symbol's.
execute_process(COMMAND ${READELF} --section-groups --wide ${ARCHIVE} OUTPUT_VARIABLE groups
                ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[][;]" " " groups "${groups}")
string(REGEX MATCHALL " ${eigen} +contains" names "${groups}")
list(TRANSFORM names REPLACE "^ ([^ ]+) .*" "\\1")
list(APPEND names ${weak})
list(REMOVE_DUPLICATES names)
list(TRANSFORM names REPLACE "(.+)" "\\1 tagcal\\1\n")
string(JOIN "" renamed ${names})
file(WRITE ${ARCHIVE}.renamed "${renamed}")
execute_process(COMMAND ${OBJCOPY} --redefine-syms=${ARCHIVE}.renamed ${ARCHIVE}
                COMMAND_ERROR_IS_FATAL ANY)
