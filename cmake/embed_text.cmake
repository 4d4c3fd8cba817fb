# Writes a C++ source with files as texts: cmake -DOUT=FILE -DNAMES=a,b -DFILES=A,B -P embed_text.cmake
string(REPLACE "," ";" names "${NAMES}")
string(REPLACE "," ";" files "${FILES}")
set(source "// Made by cmake/embed_text.cmake.\n#include \"page_data/page_assets.hpp\"\n\nnamespace tagcal::tools {\n")
foreach(name file IN ZIP_LISTS names files)
  file(READ "${file}" hex HEX)
  string(LENGTH "${hex}" length)
  math(EXPR bytes "${length} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," numbers "${hex}")
  string(REGEX REPLACE "((0x..,){24})" "\\1\n" numbers "${numbers}")
  string(APPEND source "static constexpr unsigned char ${name}_bytes[] = {${numbers}};\n"
         "std::string_view ${name}() { return {reinterpret_cast<const char*>(${name}_bytes), ${bytes}}; }\n")
endforeach()
file(WRITE "${OUT}" "${source}}  // namespace tagcal::tools\n")
