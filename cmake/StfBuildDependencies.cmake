# What is needed to build, and not by who links what was built: headers of eigenvalues, JSON, options and PNG, and what the
# tools draw with.
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(nlohmann_json 3 REQUIRED CONFIG)
find_package(CLI11 2 REQUIRED CONFIG)
find_path(STB_INCLUDE_DIR stb_image_write.h PATH_SUFFIXES stb REQUIRED)
add_library(stf_stb INTERFACE)
target_include_directories(stf_stb SYSTEM INTERFACE ${STB_INCLUDE_DIR})
# Drawings of the tools: sheets of materials and volumes.
find_path(CAIRO_INCLUDE_DIR cairo.h PATH_SUFFIXES cairo REQUIRED)
find_library(CAIRO_LIBRARY cairo REQUIRED)
add_library(stf_cairo INTERFACE)
target_include_directories(stf_cairo SYSTEM INTERFACE ${CAIRO_INCLUDE_DIR})
target_link_libraries(stf_cairo INTERFACE ${CAIRO_LIBRARY})
