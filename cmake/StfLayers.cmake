# One target per layer of stfLib, with the layers it may use. The build fails where a source includes a header of a
# layer that is not on its list, so that the layers stay one-directional (docs/architecture.md).

# Warnings of the project's own code are errors where it is tested, not where another compiler, or the headers of another
# OpenUSD, have something to say to a user's build. The headers of others are system headers.
set(_werror OFF)
if(DEFINED ENV{CI})
    set(_werror ON)
endif()
option(HDSTF_WERROR "Warnings of the project's own code are errors (default: where CI is set)" ${_werror})
add_library(stf_options INTERFACE)
target_compile_options(stf_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow $<$<BOOL:${HDSTF_WERROR}>:-Werror>)
target_link_libraries(stf_options INTERFACE stf_sanitize)

# The order in which layers stand on each other; a layer may use those before it only.
set(STF_LAYER_ORDER base optics volume acquire transport surface synthesis shell core render reference cache)

# Third-party targets that are headers alone: who links a layer from an installed package needs none of them.
set(STF_HEADER_ONLY Eigen3::Eigen nlohmann_json::nlohmann_json stf_stb)

# stf_layer(<name> SOURCES ... [LAYERS ...] [LINKS ...])
#   LAYERS  the layers it uses (transitively known through them as well)
#   LINKS   third-party targets, private: no public header of stfLib names their types
function(stf_layer name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LAYERS;LINKS" ${ARGN})
    list(FIND STF_LAYER_ORDER ${name} own_rank)
    if(own_rank LESS 0)
        message(FATAL_ERROR "stf_layer: '${name}' is not in STF_LAYER_ORDER")
    endif()
    foreach(layer IN LISTS ARG_LAYERS)
        list(FIND STF_LAYER_ORDER ${layer} rank)
        if(rank LESS 0 OR NOT rank LESS own_rank)
            message(FATAL_ERROR "stf_layer: '${name}' may not use '${layer}': layers are one-directional")
        endif()
    endforeach()

    add_library(stf_${name} STATIC ${ARG_SOURCES})
    target_include_directories(stf_${name} PUBLIC
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
    set_target_properties(stf_${name} PROPERTIES EXPORT_NAME ${name})
    add_library(stf::${name} ALIAS stf_${name})
    foreach(layer IN LISTS ARG_LAYERS)
        target_link_libraries(stf_${name} PUBLIC stf_${layer})
    endforeach()
    target_link_libraries(stf_${name} PRIVATE $<BUILD_INTERFACE:stf_options>)
    foreach(link IN LISTS ARG_LINKS)
        if(link IN_LIST STF_HEADER_ONLY)
            set(link $<BUILD_INTERFACE:${link}>)
        endif()
        target_link_libraries(stf_${name} PRIVATE ${link})
    endforeach()

    file(GLOB files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.h ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
    foreach(file IN LISTS files)
        file(STRINGS ${file} includes REGEX "^#include \"(stfLib|hdStf|pxr|tools)/")
        foreach(include IN LISTS includes)
            if(NOT include MATCHES "\"stfLib/([a-z]+)/")
                message(FATAL_ERROR "${file}: stfLib includes nothing of the layers above it: ${include}")
            endif()
            set(layer ${CMAKE_MATCH_1})
            if(NOT layer STREQUAL name AND NOT layer IN_LIST ARG_LAYERS)
                message(FATAL_ERROR "${file}: layer '${name}' may not include layer '${layer}' (allowed: ${ARG_LAYERS})")
            endif()
        endforeach()
    endforeach()
endfunction()
