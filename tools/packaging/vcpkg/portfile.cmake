# The library from this clone, without the command. Not tried.
set(SOURCE_PATH ${CMAKE_CURRENT_LIST_DIR}/../../..)
# tagcal includes stb/stb_image.h, as Debian has it.
file(COPY ${CURRENT_INSTALLED_DIR}/include/stb_image.h DESTINATION ${CURRENT_BUILDTREES_DIR}/stb_folder/stb)
vcpkg_cmake_configure(
  SOURCE_PATH ${SOURCE_PATH}
  OPTIONS -D TAGCAL_BUILD_TOOLS=OFF -D TAGCAL_BUILD_TESTS=OFF
          -D STB_INCLUDE_DIR=${CURRENT_BUILDTREES_DIR}/stb_folder)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/tagcal)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE ${CURRENT_PACKAGES_DIR}/debug/include ${CURRENT_PACKAGES_DIR}/debug/share)
vcpkg_install_copyright(FILE_LIST ${SOURCE_PATH}/LICENSE)
