# Makes of an installed tree what Debian expects below /usr/share. CPack includes it before it packs
# (CPACK_PRE_BUILD_SCRIPTS).
set(usr ${CPACK_TEMPORARY_DIRECTORY}/usr)
set(doc ${usr}/share/doc/tagcal)
if(CPACK_TAGCAL_FLAGS MATCHES "-m(arch|cpu|tune)=native")
  message(FATAL_ERROR "CMAKE_CXX_FLAGS has ${CMAKE_MATCH_0}: the package would run on processors like this "
                      "one only. Configure the build without it.")
endif()
find_program(GZIP gzip REQUIRED)

function(compress)
  if(ARGN)
    execute_process(COMMAND ${GZIP} --best --no-name --force ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
  endif()
endfunction()

file(GLOB_RECURSE pages ${usr}/share/man/*.1)
compress(${pages})
file(COPY_FILE ${CPACK_TAGCAL_CHANGELOG} ${doc}/changelog)
compress(${doc}/changelog)
file(REMOVE ${doc}/LICENSE)  # `copyright` has it
# Debian's zsh does not look into site-functions below /usr/share.
file(MAKE_DIRECTORY ${usr}/share/zsh/vendor-completions)
file(RENAME ${usr}/share/zsh/site-functions/_tagcal ${usr}/share/zsh/vendor-completions/_tagcal)
file(REMOVE_RECURSE ${usr}/share/zsh/site-functions)

# Whatever the user's umask is.
set(for_all OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
file(CHMOD ${doc}/changelog.gz FILE_PERMISSIONS ${for_all})
file(CHMOD_RECURSE ${usr} DIRECTORY_PERMISSIONS ${for_all} OWNER_EXECUTE GROUP_EXECUTE WORLD_EXECUTE)
