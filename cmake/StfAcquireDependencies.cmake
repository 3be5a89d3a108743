# Third-party packages of the layer acquire: readers of meshes and scans. Installed with stfLib's package, for its component
# `acquire`.

# Debian's config of assimp names a folder of headers that a package may not have.
find_package(assimp 5 REQUIRED CONFIG)
find_package(ZLIB REQUIRED)
# ITK's configuration prints pages about programs of other packages.
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(ITK 5 REQUIRED CONFIG
    COMPONENTS ITKIOImageBase ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD ITKIOTIFF)
unset(CMAKE_MESSAGE_LOG_LEVEL)
if(NOT TARGET stf_itk)
    add_library(stf_itk INTERFACE IMPORTED GLOBAL)
    set_target_properties(stf_itk PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${ITK_INCLUDE_DIRS}"
        INTERFACE_LINK_LIBRARIES "${ITK_LIBRARIES}")
endif()
