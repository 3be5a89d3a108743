# Where OpenUSD is one library, the names of its parts stand for that one.
function(hdstf_one_openusd_library target)
    foreach(name IN ITEMS arch tf gf work plug vt sdf sdr usd usdGeom usdLux usdRender usdShade hf hd hdsi usdImaging)
        add_library(${name} INTERFACE IMPORTED)
        target_link_libraries(${name} INTERFACE ${target})
    endforeach()
endfunction()
