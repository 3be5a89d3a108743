# Third-party packages of stfLib, found in the system or in any prefix of CMAKE_PREFIX_PATH. Nothing is vendored.
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
add_library(stf_opensubdiv UNKNOWN IMPORTED GLOBAL)
set_target_properties(stf_opensubdiv PROPERTIES
    IMPORTED_LOCATION ${OpenSubdiv_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OpenSubdiv_INCLUDE_DIR})

# Header-only or small helpers: eigenvalues, counter-based random numbers, hashing, JSON, options, PNG.
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)
find_path(STB_INCLUDE_DIR stb_image_write.h PATH_SUFFIXES stb REQUIRED)
find_package(nlohmann_json 3 REQUIRED CONFIG)
find_package(CLI11 2 REQUIRED CONFIG)
foreach(lib RANDOM123 XXHASH STB)
    string(TOLOWER stf_${lib} target)
    add_library(${target} INTERFACE)
    target_include_directories(${target} SYSTEM INTERFACE ${${lib}_INCLUDE_DIR})
    if(${lib}_LIBRARY)
        target_link_libraries(${target} INTERFACE ${${lib}_LIBRARY})
    endif()
endforeach()

# Readers of meshes (layer acquire). Debian's config names a folder of headers that a package may not have.
find_package(assimp 5 REQUIRED CONFIG)
# Drawings of the tools: sheets of materials and volumes.
find_path(CAIRO_INCLUDE_DIR cairo.h PATH_SUFFIXES cairo REQUIRED)
find_library(CAIRO_LIBRARY cairo REQUIRED)
add_library(stf_cairo INTERFACE)
target_include_directories(stf_cairo SYSTEM INTERFACE ${CAIRO_INCLUDE_DIR})
target_link_libraries(stf_cairo INTERFACE ${CAIRO_LIBRARY})

# Readers of scans. ITK's configuration prints pages about programs of other packages.
find_package(ZLIB REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(ITK 5 REQUIRED CONFIG
    COMPONENTS ITKIOImageBase ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD ITKIOTIFF)
unset(CMAKE_MESSAGE_LOG_LEVEL)
add_library(stf_itk INTERFACE)
target_include_directories(stf_itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS})
target_link_libraries(stf_itk INTERFACE ${ITK_LIBRARIES})
