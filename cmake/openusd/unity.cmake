# Injected into OpenUSD's own project() call (CMAKE_PROJECT_usd_INCLUDE). Most of the time of a plain build goes into
# parsing boost, TBB and vt headers again for each of 700 small files, so all libraries are compiled in unity batches.
# OpenUSD's sources are not written for that: names local to a file clash. Before each file of a batch such names are
# turned into macros that append a name unique to that file.
cmake_policy(SET CMP0057 NEW)

function(_hdstf_tune_openusd)
    # Names local to several files of one library. None of them is part of an interface.
    set(local_names _tokens _schemaTokens _ConcatenateAttributeNames _ComputeExtentMax _GetImplicitGeomScaleTransform
        _BuildArray _ListEditImpl)
    # Generated parsers clash in everything; stage.cpp and crateFile.cpp take so long that they are batches themselves.
    set(alone_sdf path.tab.cpp path.lex.cpp textFileFormat.tab.cpp textFileFormat.lex.cpp)
    set(alone_usd stage.cpp crateFile.cpp)

    set(rename "#define HDSTF_CAT_(a, b) a##b\n#define HDSTF_CAT(a, b) HDSTF_CAT_(a, b)\n")
    foreach(name IN LISTS local_names)
        string(APPEND rename "#undef ${name}\n#define ${name} HDSTF_CAT(${name}_, HDSTF_UNIT)\n")
    endforeach()
    # Registry functions are named after their line: two files may have one on the same line.
    string(CONCAT registry "#include \"pxr/base/tf/registryManager.h\"\n"
        "#undef TF_REGISTRY_FUNCTION\n"
        "#define TF_REGISTRY_FUNCTION(KEY) TF_REGISTRY_DEFINE(KEY, HDSTF_CAT(HDSTF_UNIT, __LINE__))\n")

    foreach(target IN LISTS PXR_ALL_LIBS)
        if(NOT TARGET ${target})
            continue()
        endif()
        set(before "${rename}")
        if(NOT target STREQUAL "arch") # the one library below tf
            string(APPEND before "${registry}")
        endif()
        set_target_properties(${target} PROPERTIES
            UNITY_BUILD ON
            UNITY_BUILD_BATCH_SIZE 10
            UNITY_BUILD_UNIQUE_ID HDSTF_UNIT
            UNITY_BUILD_CODE_BEFORE_INCLUDE "${before}")
        get_target_property(folder ${target} SOURCE_DIR)
        foreach(file IN LISTS alone_${target})
            set_source_files_properties(${folder}/${file} DIRECTORY ${folder}
                PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
        endforeach()
    endforeach()
endfunction()
cmake_language(DEFER DIRECTORY ${CMAKE_SOURCE_DIR} CALL _hdstf_tune_openusd)
