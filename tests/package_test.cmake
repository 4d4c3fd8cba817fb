# Makes a Debian package of the build, unpacks it with dpkg-deb into a folder of its own, and uses what
# is inside. Run as
#   cmake -D BUILD=<build tree> -D SOURCE=<source tree> -D SCRATCH=<folder> -D COMPILER=<c++>
#         -D PYTHON=<interpreter of the module, or empty> -P package_test.cmake
cmake_minimum_required(VERSION 3.23)

foreach(tool IN ITEMS dpkg-deb dpkg-shlibdeps file readelf gzip)
  find_program(found_${tool} ${tool})
  if(NOT found_${tool})
    message(STATUS "package_test skipped: ${tool} is missing")
    return()
  endif()
endforeach()

function(run what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${SCRATCH} RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(check_matches what text)
  foreach(pattern IN LISTS ARGN)
    if(NOT text MATCHES "${pattern}")
      message(FATAL_ERROR "${what} must match ${pattern}, but is:\n${text}")
    endif()
  endforeach()
endfunction()

function(check_has what text part)
  string(FIND "${text}" "${part}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "${what} must have ${part}, but is:\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH})
# Without compression, which takes most of the time, and by a user whose files nobody else may read.
run("cpack" sh -c "umask 077 && exec \"$@\"" sh ${CMAKE_CPACK_COMMAND} --config ${BUILD}/CPackConfig.cmake -B ${SCRATCH}
    -D CPACK_DEBIAN_COMPRESSION_TYPE=none)
file(GLOB deb ${SCRATCH}/*.deb)
file(REMOVE_RECURSE ${SCRATCH}/_CPack_Packages)
check_matches("the file name" "${deb}" "/tagcal_[0-9.]+-1_[a-z0-9]+\\.deb$")
set(root "${SCRATCH}/root of the package")
set(usr ${root}/usr)
run("dpkg-deb -x" dpkg-deb -x ${deb} ${root})

# What the package says of itself.
run("Depends" dpkg-deb --field ${deb} Depends)
check_matches("Depends" "${output}" libc6 libapriltag libopencv-core libopencv-calib3d "libopencv-(contrib|objdetect)"
              libcairo2 libyaml-cpp libfmt libpng libjpeg libtiff libwebp libdeflate libgoogle-glog)
set(depends "${output}")
run("Recommends" dpkg-deb --field ${deb} Recommends)
check_matches("Recommends" "${output}" libceres-dev libopencv-dev libeigen3-dev libheif1 libavformat libswscale)
run("Description" dpkg-deb --field ${deb} Description)
check_matches("Description" "${output}" "^camera calibration")

# The files: complete, for everybody to read and for root alone to write, owned by root.
set(files bin/tagcal include/tagcal/tagcal.hpp include/tagcal/estimate/pose.hpp lib/libtagcal.a lib/libtagcal.so
          lib/libtagcal_validate.a lib/cmake/tagcal/tagcalConfig.cmake lib/pkgconfig/tagcal.pc
          share/bash-completion/completions/tagcal share/zsh/vendor-completions/_tagcal
          share/fish/vendor_completions.d/tagcal.fish share/man/man1/tagcal.1.gz
          share/man/man1/tagcal-calibrate.1.gz share/doc/tagcal/changelog.gz share/doc/tagcal/copyright)
if(PYTHON)
  list(APPEND files lib/python3/dist-packages/tagcal/__init__.py
              lib/python3/dist-packages/tagcal/py.typed)
endif()
foreach(file IN LISTS files)
  if(NOT EXISTS ${usr}/${file})
    message(FATAL_ERROR "the package lacks /usr/${file}")
  endif()
endforeach()
run("contents" dpkg-deb --contents ${deb})
string(REGEX MATCHALL "[^\n]+" lines "${output}")
foreach(line IN LISTS lines)
  check_matches("an entry" "${line}" "^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--|lrwxrwxrwx) root/root ")
endforeach()
file(GLOB pages ${usr}/share/man/man1/*)
run("gzip --test" gzip --test ${pages} ${usr}/share/doc/tagcal/changelog.gz)

# The licences of what the programs contain.
file(READ ${usr}/share/doc/tagcal/copyright copyright)
file(READ ${SOURCE}/LICENSE license)
file(READ ${SOURCE}/tools/page/dist/LICENSES page_licenses)
foreach(text IN ITEMS "${license}" "${page_licenses}" Ceres CLI11 nlohmann stb_image MPL)
  check_has("copyright" "${copyright}" "${text}")
endforeach()

# Nothing refers to the folders of the build.
execute_process(COMMAND grep --recursive --files-with-matches --fixed-strings -e ${BUILD}/ -e ${SOURCE}/lib/
                        -e ${SOURCE}/tools/ ${usr} OUTPUT_VARIABLE output RESULT_VARIABLE result)
if(NOT result EQUAL 1)
  message(FATAL_ERROR "files of the package refer to ${BUILD} or ${SOURCE}:\n${output}")
endif()
file(GLOB modules ${usr}/lib/python3/dist-packages/tagcal/*.so)
foreach(program IN ITEMS ${usr}/bin/tagcal ${usr}/lib/libtagcal.so ${modules})
  run("readelf" readelf --dynamic --section-headers ${program})
  if(output MATCHES "RPATH|RUNPATH|debug_info")
    message(FATAL_ERROR "${program} has ${CMAKE_MATCH_0}")
  endif()
endforeach()

# The command does its job.
set(tagcal ${usr}/bin/tagcal)
run("--version" ${tagcal} --version)
file(STRINGS ${SOURCE}/CMakeLists.txt version REGEX "^project\\(tagcal VERSION")
string(REGEX MATCH "[0-9.]+" version "${version}")
check_matches("--version" "${output}" "^tagcal ${version}\nbuilt with Ceres 2")
run("render" ${tagcal} render ${SOURCE}/data-synthetic/scenes/desk.yaml --views 8 --out desk)
run("calibrate" ${tagcal} calibrate desk --out camera.yaml)
check_matches("calibrate" "${output}" "OK: ")
run("report" ${tagcal} report camera.yaml --dataset desk --out report.html)

# The library is found, by CMake and by pkg-config.
file(WRITE ${SCRATCH}/consumer/CMakeLists.txt [[
cmake_minimum_required(VERSION 3.23)
project(consumer LANGUAGES CXX)
find_package(tagcal REQUIRED COMPONENTS validate)
get_target_property(include tagcal::tagcal INTERFACE_INCLUDE_DIRECTORIES)
get_target_property(library tagcal::validate IMPORTED_LOCATION_RELEASE)
message(STATUS "include ${include}, library ${library}")
]])
run("find_package" ${CMAKE_COMMAND} -G Ninja -S ${SCRATCH}/consumer -B ${SCRATCH}/consumer/build
    -D CMAKE_PREFIX_PATH=${usr} -D CMAKE_CXX_COMPILER=${COMPILER})
check_has("find_package" "${output}" "include ${usr}/include, library ${usr}/lib/libtagcal_validate.a")
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} ${usr}/lib/pkgconfig)
  run("pkg-config" ${PKG_CONFIG} --cflags --libs tagcal)
endif()

if(PYTHON)
  check_matches("Depends" "${depends}" "python3 \\(>= 3\\.[0-9]+\\), python3 \\(<< 3\\.[0-9]+\\), python3-numpy")
  set(ENV{PYTHONPATH} ${usr}/lib/python3/dist-packages)
  run("import tagcal" ${PYTHON} -B -c "import tagcal\nprint(tagcal.__version__, tagcal.__file__)")
  check_has("import tagcal" "${output}" "${version} ${usr}/lib/python3/dist-packages/tagcal/")
elseif(modules)
  message(FATAL_ERROR "the package has the Python module, which was not built for Debian's Python")
endif()
file(REMOVE_RECURSE ${SCRATCH})
