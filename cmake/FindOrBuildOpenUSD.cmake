# OpenUSD with Hydra: the user's own if there is one, else 20.08 built once into a cache folder (openusd/).
#
# Looked at, in this order: PXR_ROOT, pxr_ROOT and pxr_DIR (CMake variables, then environment variables), CMAKE_PREFIX_PATH
# (likewise), /usr/local, /usr. Include this from the top-level CMakeLists.txt: OpenUSD's imported targets (hd, usdImaging,
# tf, ...) have no namespace and are seen only in the folder of the find_package call and below it.
#
# Sets HDSTF_OPENUSD_ROOT.
#
# OpenUSD's targets bring the include folder of the TBB it was built with; for 20.08 that is the classic TBB, while
# OpenVDB and Embree use oneTBB. Nothing that includes OpenVDB may link one of these targets.
option(HDSTF_BUILD_OPENUSD "Build OpenUSD 20.08 (some minutes, once) where no OpenUSD with Hydra is found" ON)

# Folder of an acceptable pxrConfig.cmake in one of the given folders, or empty. The file is read before it is loaded:
# the targets of an OpenUSD without Hydra could not be replaced by those of another one afterwards.
function(_hdstf_search_openusd result)
    set(${result} "" PARENT_SCOPE)
    foreach(root IN LISTS ARGN)
        foreach(suffix "" /lib/cmake/pxr /lib64/cmake/pxr /cmake)
            set(folder "${root}${suffix}")
            if(NOT root OR NOT EXISTS "${folder}/pxrConfig.cmake")
                continue()
            endif()
            file(STRINGS "${folder}/pxrConfig.cmake" libraries REGEX "^ *set\\(libs ")
            if(libraries MATCHES "[^A-Za-z]hd[^A-Za-z]" AND libraries MATCHES "[^A-Za-z]usdImaging[^A-Za-z]")
                set(${result} "${folder}" PARENT_SCOPE)
                return()
            endif()
            message(STATUS "OpenUSD in ${folder} is passed over: it has no Hydra (libraries hd and usdImaging)")
        endforeach()
    endforeach()
endfunction()

# An earlier run's own build is looked up anew: the recipe may have changed, the cache folder may be gone.
if(DEFINED CACHE{pxr_DIR} AND pxr_DIR STREQUAL "$CACHE{HDSTF_BUILT_OPENUSD}")
    unset(pxr_DIR CACHE)
endif()

# PXR_ROOT before pxr_DIR: the latter may be in the cache from an earlier run.
set(_roots ${PXR_ROOT} ${pxr_ROOT} ${pxr_DIR})
foreach(_name PXR_ROOT pxr_ROOT pxr_DIR)
    list(APPEND _roots $ENV{${_name}})
endforeach()
set(_asked ${_roots})
list(APPEND _roots ${CMAKE_PREFIX_PATH})
if(DEFINED ENV{CMAKE_PREFIX_PATH})
    string(REPLACE ":" ";" _more "$ENV{CMAKE_PREFIX_PATH}")
    list(APPEND _roots ${_more})
endif()
_hdstf_search_openusd(_found ${_roots} /usr/local /usr)

if(NOT _found AND _asked)
    message(FATAL_ERROR "No OpenUSD with Hydra (a pxrConfig.cmake that lists hd and usdImaging) in: ${_asked}\n"
        "Correct PXR_ROOT or pxr_DIR, or unset it to have OpenUSD built.")
endif()
if(NOT _found AND NOT HDSTF_BUILD_OPENUSD)
    message(FATAL_ERROR "No OpenUSD with Hydra was found. Give its prefix as -DPXR_ROOT=<prefix>, or allow "
        "-DHDSTF_BUILD_OPENUSD=ON to build one, or leave the delegate out with -DHDSTF_BUILD_HYDRA=OFF.")
endif()
if(NOT _found)
    find_package(Python3 3.7 QUIET COMPONENTS Interpreter)
    if(NOT Python3_Interpreter_FOUND)
        message(FATAL_ERROR "Building OpenUSD needs Python 3: install the Debian package python3.")
    endif()
    set(_build ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/openusd/build_openusd.py --cxx ${CMAKE_CXX_COMPILER})
    execute_process(COMMAND ${_build} --query RESULT_VARIABLE _code OUTPUT_VARIABLE _prefix ERROR_VARIABLE _error
        OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT _code EQUAL 0 AND NOT _code EQUAL 3)
        message(FATAL_ERROR "${_error}")
    endif()
    if(_code EQUAL 3)
        message(STATUS "No OpenUSD with Hydra was found: building 20.08 in ${_prefix} (once)")
        execute_process(COMMAND ${_build} RESULT_VARIABLE _code)
        if(NOT _code EQUAL 0)
            message(FATAL_ERROR "OpenUSD was not built, see above. Mend it and configure again (what is done stays), or "
                "give the prefix of an OpenUSD with Hydra as -DPXR_ROOT=<prefix>.")
        endif()
    endif()
    set(_found "${_prefix}")
    set(HDSTF_BUILT_OPENUSD "${_prefix}" CACHE INTERNAL "The OpenUSD this project built")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
        ${CMAKE_CURRENT_LIST_DIR}/openusd/build_openusd.py ${CMAKE_CURRENT_LIST_DIR}/openusd/unity.cmake)
endif()

set(pxr_DIR "${_found}" CACHE PATH "Folder of OpenUSD's pxrConfig.cmake" FORCE)
find_package(pxr REQUIRED CONFIG NO_CMAKE_PACKAGE_REGISTRY)
if(NOT TARGET hd OR NOT TARGET usdImaging)
    # Built as one library: usd_ms, which newer versions name together with the static one that it is made from.
    if(NOT TARGET usd_ms)
        message(FATAL_ERROR "OpenUSD in ${_found} exports neither the targets hd and usdImaging nor usd_ms")
    endif()
    include(${CMAKE_CURRENT_LIST_DIR}/OneOpenUSDLibrary.cmake)
    hdstf_one_openusd_library(usd_ms)
endif()
set(HDSTF_OPENUSD_ROOT "${_found}")
