# Where installed programs and the plugin look for libraries that are not the system's.
#
# HDSTF_INSTALL_OPENUSD puts the OpenUSD of this build into the install tree (lib/openusd), with all else that is not the
# system's, so that the tree can be moved and given away. Off, the tree names the folders that it was linked against. The
# OpenUSD of a host (HDSTF_OPENUSD_LIBRARY), one that is a single library (usd_ms) and that of the system stay where they
# are.
set(_bundle OFF)
if(HDSTF_BUILD_HYDRA AND NOT HDSTF_OPENUSD_LIBRARY AND NOT TARGET usd_ms AND NOT APPLE)
    get_target_property(_file hd LOCATION)
    get_filename_component(HDSTF_OPENUSD_LIBRARY_FOLDER "${_file}" DIRECTORY)
    if(NOT HDSTF_OPENUSD_LIBRARY_FOLDER MATCHES "^/(usr/)?lib")
        set(_bundle ON)
    endif()
endif()
option(HDSTF_INSTALL_OPENUSD "Install the OpenUSD of this build along with hdStf" ${_bundle})
if(HDSTF_INSTALL_OPENUSD AND NOT HDSTF_OPENUSD_LIBRARY_FOLDER)
    message(FATAL_ERROR "HDSTF_INSTALL_OPENUSD: there is no OpenUSD of many libraries here to install along with hdStf.")
endif()

# stf_install_target(<name> <kind> <folder>): installs a program or the plugin with what it needs to find its libraries
# from anywhere.
function(stf_install_target name kind folder)
    if(HDSTF_INSTALL_OPENUSD)
        set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib/openusd")
        install(TARGETS ${name} RUNTIME_DEPENDENCY_SET stf_runtime ${kind} DESTINATION ${folder})
    else()
        # An OpenUSD in the same prefix is found wherever that goes.
        set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib" INSTALL_RPATH_USE_LINK_PATH ON)
        install(TARGETS ${name} ${kind} DESTINATION ${folder})
    endif()
endfunction()
