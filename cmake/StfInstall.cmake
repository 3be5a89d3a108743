# The install tree (docs/install.md):
#   bin/                     stf, stfrecord
#   plugin/                  for PXR_PLUGINPATH_NAME: hdStf and the schemas (installed where they are made)
#   lib/openusd/             the OpenUSD of this build, with HDSTF_INSTALL_OPENUSD
#   lib/, include/stfLib/    stfLib as static libraries, its public headers
#   lib/cmake/stfLib/        find_package(stfLib CONFIG), targets stf::stfLib, stf::render, ...
#   share/hdstf/             the Blender add-on, the example scenes with their volumes, the program of `stf report`
#   share/doc/hdstf/         this documentation
include(CMakePackageConfigHelpers)

# Libraries. The layer acquire apart: a component, since it asks for ITK and assimp.
set(stf_layers ${STF_LAYER_ORDER})
list(REMOVE_ITEM stf_layers acquire)
list(TRANSFORM stf_layers PREPEND stf_)
install(TARGETS ${stf_layers} stfLib EXPORT stfLibTargets ARCHIVE DESTINATION lib)
install(TARGETS stf_acquire EXPORT stfLibAcquireTargets ARCHIVE DESTINATION lib)

# Headers: all but those that say that they are private, which may name types of third-party libraries.
file(GLOB_RECURSE _headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} stfLib/*.h)
foreach(_header IN LISTS _headers)
    file(STRINGS ${_header} _private LIMIT_COUNT 1 REGEX "^// Private to ")
    if(NOT _private)
        get_filename_component(_folder ${_header} DIRECTORY)
        install(FILES ${_header} DESTINATION include/${_folder})
    endif()
endforeach()

# The package.
set(_package lib/cmake/stfLib)
install(EXPORT stfLibTargets NAMESPACE stf:: DESTINATION ${_package})
install(EXPORT stfLibAcquireTargets NAMESPACE stf:: DESTINATION ${_package})
configure_package_config_file(cmake/stfLibConfig.cmake.in ${CMAKE_BINARY_DIR}/package/stfLibConfig.cmake
    INSTALL_DESTINATION ${_package} NO_SET_AND_CHECK_MACRO)
# 0.x: any minor version may change functions.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/stfLibConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/stfLibConfig.cmake ${CMAKE_BINARY_DIR}/package/stfLibConfigVersion.cmake
    cmake/StfDependencies.cmake cmake/StfAcquireDependencies.cmake DESTINATION ${_package})

# Files as they are.
install(DIRECTORY docs/ DESTINATION share/doc/hdstf/docs)
install(FILES README.md LICENSE CHANGELOG.md DESTINATION share/doc/hdstf)
install(DIRECTORY tools/blender/hdstf_blender DESTINATION share/hdstf/blender PATTERN "__pycache__" EXCLUDE)

# OpenUSD: the libraries that the programs and the plugin load, and what plugInfo.json says of them.
if(HDSTF_INSTALL_OPENUSD)
    install(RUNTIME_DEPENDENCY_SET stf_runtime DESTINATION lib/openusd
        POST_EXCLUDE_REGEXES "^/lib" "^/usr/lib"
        DIRECTORIES ${HDSTF_OPENUSD_LIBRARY_FOLDER})
    install(CODE "set(from \"${HDSTF_OPENUSD_LIBRARY_FOLDER}/usd\")")
    install(CODE [[
        set(to "${CMAKE_INSTALL_PREFIX}/lib/openusd")
        file(INSTALL "${from}/plugInfo.json" DESTINATION "$ENV{DESTDIR}${to}/usd")
        file(GLOB names RELATIVE "${from}" "${from}/*")
        foreach(name IN LISTS names)
            file(GLOB library "$ENV{DESTDIR}${to}/lib${name}.*" "$ENV{DESTDIR}${to}/lib*_${name}.*")
            if(library)
                file(INSTALL "${from}/${name}" DESTINATION "$ENV{DESTDIR}${to}/usd")
            endif()
        endforeach()
    ]])
endif()
