# Installs the build BUILD into INSTALLED and moves that to TREE, so that nothing can refer to where it was.
file(REMOVE_RECURSE ${INSTALLED} ${TREE})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${INSTALLED} COMMAND_ERROR_IS_FATAL ANY
    OUTPUT_QUIET)
file(RENAME ${INSTALLED} ${TREE})
