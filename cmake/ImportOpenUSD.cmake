# An OpenUSD that comes as one library without a CMake configuration, such as a program's own (Blender: libusd_ms.so):
#
#   HDSTF_OPENUSD_LIBRARY  the library
#   HDSTF_OPENUSD_HEADERS  folders of the headers it was built with. The first one holds pxr/pxr.h, which has the
#                          version and the namespace; further ones hold what those headers include and the system has
#                          in another version (classic TBB)
#
# Makes the targets this project names (hd, usdImaging, ...), all of which are that library, and PXR_INCLUDE_DIRS. A plugin
# with the wrong namespace or of another version would fail when it is loaded, which is late: both are compared here.
set(HDSTF_OPENUSD_LIBRARY "" CACHE FILEPATH "OpenUSD in one library, in place of one with a pxrConfig.cmake")
set(HDSTF_OPENUSD_HEADERS "" CACHE STRING "Folders of the headers of HDSTF_OPENUSD_LIBRARY; the first has pxr/pxr.h")
if(NOT HDSTF_OPENUSD_LIBRARY AND NOT HDSTF_OPENUSD_HEADERS)
    return()
endif()

list(GET HDSTF_OPENUSD_HEADERS 0 _include)
if(NOT EXISTS "${HDSTF_OPENUSD_LIBRARY}" OR IS_DIRECTORY "${HDSTF_OPENUSD_LIBRARY}")
    message(FATAL_ERROR "HDSTF_OPENUSD_LIBRARY is no file: '${HDSTF_OPENUSD_LIBRARY}'")
endif()
if(NOT EXISTS "${_include}/pxr/pxr.h")
    message(FATAL_ERROR "HDSTF_OPENUSD_HEADERS has no pxr/pxr.h in its first folder: '${_include}'\n"
        "A source tree has pxr/pxr.h.in only: tools/setup/openusd_headers.py makes headers from it.")
endif()
file(STRINGS "${_include}/pxr/pxr.h" _namespace REGEX "#define PXR_INTERNAL_NS ")
string(REGEX REPLACE ".*PXR_INTERNAL_NS +([A-Za-z0-9_]+).*" "\\1" _namespace "${_namespace}")
# The name of a type in the library's strings is its length and itself, as compilers mangle it.
file(STRINGS "${HDSTF_OPENUSD_LIBRARY}" _known LIMIT_COUNT 1 REGEX "${_namespace}.*16HdRenderDelegate")
if(NOT _known)
    message(FATAL_ERROR "${HDSTF_OPENUSD_LIBRARY} has no class HdRenderDelegate in the namespace ${_namespace} of "
        "${_include}/pxr/pxr.h: headers of another OpenUSD, or one without Hydra.")
endif()

set(HDSTF_OPENUSD_ROOT "${HDSTF_OPENUSD_LIBRARY}")
set(PXR_INCLUDE_DIRS ${HDSTF_OPENUSD_HEADERS})
add_library(hdstf_openusd SHARED IMPORTED)
set_target_properties(hdstf_openusd PROPERTIES
    IMPORTED_LOCATION "${HDSTF_OPENUSD_LIBRARY}"
    IMPORTED_NO_SONAME ON)
target_include_directories(hdstf_openusd SYSTEM INTERFACE ${PXR_INCLUDE_DIRS})
file(STRINGS "${_include}/pxr/pxr.h" _python REGEX "^#define PXR_PYTHON_SUPPORT_ENABLED")
if(_python)
    # Python's headers are part of OpenUSD's. Its library is for executables: a host of a plugin has Python in it.
    find_package(Python3 REQUIRED COMPONENTS Development)
    target_include_directories(hdstf_openusd SYSTEM INTERFACE ${Python3_INCLUDE_DIRS})
    target_link_libraries(hdstf_openusd INTERFACE
        "$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${Python3_LIBRARIES}>")
endif()
target_link_options(hdstf_openusd INTERFACE
    "$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-Wl,--no-as-needed;-Wl,--copy-dt-needed-entries;-Wl,--allow-shlib-undefined>")
include(${CMAKE_CURRENT_LIST_DIR}/OneOpenUSDLibrary.cmake)
hdstf_one_openusd_library(hdstf_openusd)
