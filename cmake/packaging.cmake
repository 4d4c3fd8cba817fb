# `cpack` in a build folder makes a Debian package of what is built there (tools/package.sh,
# docs/reference/package.md). One package: the command, the library with its headers, and the Python
# module where it was built.
set(TAGCAL_PACKAGE_MAINTAINER "the tagcal authors" CACHE STRING
    "Maintainer that the Debian package names: NAME <ADDRESS>")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tagcal)
set(CPACK_PACKAGE_CONTACT "${TAGCAL_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "camera calibration and pose from pictures of boards and tags")
set(CPACK_PACKAGE_DESCRIPTION "tagcal calibrates cameras and finds where they are from pictures of
AprilTags, checkerboards and ChArUco boards. Every number has a standard
deviation; what the pictures do not determine is refused, with a reason.
.
This package has the command, the C++20 library (with headers, CMake
package and pkg-config file) and, where it was built, the Python module.
To compile programs against the library, install the recommended packages.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
# Installed as for /usr below a staging folder, so that scripts see the prefix that they are made for.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package/debian_files.cmake)
set(CPACK_TAGCAL_CHANGELOG ${PROJECT_SOURCE_DIR}/CHANGELOG.md)
set(CPACK_TAGCAL_FLAGS "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
# What find_package(tagcal) and tagcal.pc look for. Recommended, not needed: apt installs them unless
# told otherwise, and who only wants the command is spared a gigabyte of OpenCV's own.
string(JOIN ", " CPACK_DEBIAN_PACKAGE_RECOMMENDS "libeigen3-dev (>= 3.4)" "libceres-dev (>= 2.1)"
       libapriltag-dev libyaml-cpp-dev libfmt-dev libpng-dev libjpeg-dev "libtiff-dev (>= 4.5)" libwebp-dev
       libdeflate-dev "libopencv-dev (>= 4.5)")
# The libraries that are loaded at the first HEIC picture or bag, and (FFmpeg's, by the versions of
# their headers) at the first video.
string(APPEND CPACK_DEBIAN_PACKAGE_RECOMMENDS ", libheif1, libbz2-1.0, liblz4-1, libzstd1, libsqlite3-0")
foreach(library avformat swscale)
  file(GLOB headers ${FFMPEG_INCLUDE_DIR}/lib${library}/version*.h)
  foreach(header IN LISTS headers)
    file(STRINGS ${header} line REGEX "define LIB[A-Z]+_VERSION_MAJOR +[0-9]+")
    string(REGEX MATCH "[0-9]+$" version "${line}")
    if(version)
      string(APPEND CPACK_DEBIAN_PACKAGE_RECOMMENDS ", lib${library}${version}")
      break()
    endif()
  endforeach()
endforeach()
if(TAGCAL_OPENCV_MARKERS STREQUAL aruco)
  string(APPEND CPACK_DEBIAN_PACKAGE_RECOMMENDS ", libopencv-contrib-dev (>= 4.5)")
endif()

# The Python module, if it is one for Debian's Python: another one looks into other folders.
set(part Unspecified)
set(packaged_python "")  # tests/package_test.cmake
if(TARGET tagcal_python)
  find_package(Python REQUIRED COMPONENTS Interpreter)
  execute_process(COMMAND ${Python_EXECUTABLE} ${PROJECT_SOURCE_DIR}/lib/python/install_folder.py /usr
                  OUTPUT_VARIABLE folder OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  if(folder STREQUAL "lib/python3/dist-packages" AND NOT TAGCAL_PYTHON_FOLDER)
    set(part ALL)
    set(packaged_python ${Python_EXECUTABLE})
    execute_process(COMMAND ${Python_EXECUTABLE} -c
                            "import sys; print('python3 (>= 3.%d), python3 (<< 3.%d), python3-numpy' % (
                             sys.version_info.minor, sys.version_info.minor + 1))"
                    OUTPUT_VARIABLE CPACK_DEBIAN_PACKAGE_DEPENDS OUTPUT_STRIP_TRAILING_WHITESPACE
                    COMMAND_ERROR_IS_FATAL ANY)
    set(CPACK_DEBIAN_PACKAGE_SUGGESTS python3-matplotlib)  # for tagcal.plot
    set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/package/postinst
        ${PROJECT_SOURCE_DIR}/cmake/package/prerm)
  else()
    message(STATUS "The Debian package leaves the Python module out: it is not for Debian's Python")
  endif()
endif()
set(CPACK_INSTALL_CMAKE_PROJECTS ${PROJECT_BINARY_DIR} tagcal ${part} /)
include(CPack)
