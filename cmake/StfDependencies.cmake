# Third-party packages that a program with stfLib links, found in the system or in any prefix of CMAKE_PREFIX_PATH.
# Nothing is vendored. Installed with stfLib's package, which includes this file: it may be read more than once.
find_package(Threads REQUIRED)
find_package(TBB 2021 REQUIRED CONFIG)
# Debian's Imath config lists a Python library of another package and prints a page about it.
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(OpenEXR 3 REQUIRED CONFIG)
unset(CMAKE_MESSAGE_LOG_LEVEL)
find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
    find_package(embree 3.13 REQUIRED CONFIG)
endif()

# Debian's OpenVDB comes without a CMake config: the library by name, the version from its header.
if(NOT TARGET OpenVDB::openvdb)
    find_path(OpenVDB_INCLUDE_DIR openvdb/version.h REQUIRED)
    find_library(OpenVDB_LIBRARY openvdb REQUIRED)
    file(STRINGS ${OpenVDB_INCLUDE_DIR}/openvdb/version.h OpenVDB_VERSION
        REGEX "OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER [0-9]+")
    string(REGEX MATCH "[0-9]+" OpenVDB_VERSION "${OpenVDB_VERSION}")
    if(OpenVDB_VERSION LESS 10)
        message(FATAL_ERROR "OpenVDB >= 10 is needed, found ${OpenVDB_VERSION} in ${OpenVDB_INCLUDE_DIR}")
    endif()
    add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
    set_target_properties(OpenVDB::openvdb PROPERTIES
        IMPORTED_LOCATION ${OpenVDB_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenVDB_INCLUDE_DIR}
        INTERFACE_LINK_LIBRARIES "TBB::tbb;Imath::Imath;Threads::Threads")
endif()
# Debian's OpenSubdiv config names a static library that the package does not hold: it cannot be used.
find_path(OpenSubdiv_INCLUDE_DIR opensubdiv/version.h REQUIRED)
find_library(OpenSubdiv_LIBRARY osdCPU REQUIRED)
file(STRINGS ${OpenSubdiv_INCLUDE_DIR}/opensubdiv/version.h OpenSubdiv_VERSION
    REGEX "define OPENSUBDIV_VERSION_NUMBER +[0-9]+")
string(REGEX MATCH "[0-9]+$" OpenSubdiv_VERSION "${OpenSubdiv_VERSION}")
if(OpenSubdiv_VERSION AND OpenSubdiv_VERSION LESS 30500)
    message(FATAL_ERROR "OpenSubdiv >= 3.5 is needed, found ${OpenSubdiv_VERSION} in ${OpenSubdiv_INCLUDE_DIR}")
endif()
if(NOT TARGET stf_opensubdiv)
    add_library(stf_opensubdiv UNKNOWN IMPORTED GLOBAL)
    set_target_properties(stf_opensubdiv PROPERTIES
        IMPORTED_LOCATION ${OpenSubdiv_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenSubdiv_INCLUDE_DIR})
endif()

# Counter-based random numbers (headers, which stfLib's own include) and hashing.
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)
if(NOT TARGET stf_random123)
    add_library(stf_random123 INTERFACE IMPORTED GLOBAL)
    set_target_properties(stf_random123 PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${RANDOM123_INCLUDE_DIR})
    add_library(stf_xxhash INTERFACE IMPORTED GLOBAL)
    set_target_properties(stf_xxhash PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES ${XXHASH_INCLUDE_DIR}
        INTERFACE_LINK_LIBRARIES ${XXHASH_LIBRARY})
endif()
