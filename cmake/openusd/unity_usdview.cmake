# What unity.cmake does, and what Python and GL add to it. Injected into OpenUSD's project() call in its place.
#
# The wrappers are 350 small files of boost.python templates full of file-local names that clash. They are not batched, but
# share two precompiled headers, and nothing in them is worth optimizing.
include(${CMAKE_CURRENT_LIST_DIR}/unity.cmake)

function(_hdstf_tune_usdview)
    # "using namespace boost::python" makes list, tuple and arg ambiguous for the rest of a batch.
    set(alone_tf pyArg.cpp pyEnum.cpp pyError.cpp pyErrorInternal.cpp pyExceptionState.cpp pyInterpreter.cpp
        pyModule.cpp pyNoticeWrapper.cpp pyObjectFinder.cpp pyTracing.cpp pyUtils.cpp)
    set(wrapping pyContainerConversions.h pyEnum.h pyFunction.h pyPtrHelpers.h pyResultConversions.h pyStaticTokens.h
        pyUtils.h wrapTypeHelpers.h)
    list(TRANSFORM wrapping REPLACE "(.+)" "<pxr/base/tf/\\1>")
    # As local_names of unity.cmake.
    set(local_names_hdSt FORMAT_DESC _FormatDesc _GetElementOffset _Uniquify)
    foreach(library IN LISTS PXR_ALL_LIBS)
        if(TARGET ${library})
            # They mend arch/demangle.cpp. Not for the modules: a precompiled header has to come first.
            target_compile_options(${library} PRIVATE "SHELL:-include cxxabi.h -include typeinfo")
            get_target_property(folder ${library} SOURCE_DIR)
            foreach(file IN LISTS alone_${library})
                set_source_files_properties(${folder}/${file} DIRECTORY ${folder}
                    PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
            endforeach()
            foreach(name IN LISTS local_names_${library})
                get_target_property(before ${library} UNITY_BUILD_CODE_BEFORE_INCLUDE)
                string(APPEND before "#undef ${name}\n#define ${name} HDSTF_CAT(${name}_, HDSTF_UNIT)\n")
                set_target_properties(${library} PROPERTIES UNITY_BUILD_CODE_BEFORE_INCLUDE "${before}")
            endforeach()
            if(library MATCHES "^(glf|hgiGL|hgiInterop|hdSt|hdx|usdImagingGL|usdAppUtils)$")
                # It has to be seen before any other header of OpenGL.
                get_target_property(before ${library} UNITY_BUILD_CODE_BEFORE_INCLUDE)
                set_target_properties(${library} PROPERTIES
                    UNITY_BUILD_CODE_BEFORE_INCLUDE "#include <GL/glew.h>\n${before}")
            endif()
        endif()
        if(NOT TARGET _${library})
            continue()
        endif()
        set(module _${library})
        target_compile_options(${module} PRIVATE -O0)
        if(library MATCHES "^(gf|pxOsd)$")
            # Here str must not be boost::python::str, which the others' headers bring.
            target_precompile_headers(${module} PRIVATE ${folder}/pch.h)
            continue()
        endif()
        # A precompiled header serves only those who define the same macros before it: what differs comes after it, in
        # batches of one file.
        get_target_property(definitions ${module} COMPILE_DEFINITIONS)
        list(TRANSFORM definitions REPLACE "([^=]+)=(.*)" "#define \\1 \\2\n")
        list(JOIN definitions "" definitions)
        set_target_properties(${module} PROPERTIES
            COMPILE_DEFINITIONS ""
            DEFINE_SYMBOL ""
            UNITY_BUILD ON
            UNITY_BUILD_BATCH_SIZE 1
            UNITY_BUILD_CODE_BEFORE_INCLUDE "${definitions}")
        if(library STREQUAL "tf")
            target_precompile_headers(_tf PRIVATE <boost/python.hpp> ${wrapping})
        elseif(library STREQUAL "usd")
            target_precompile_headers(_usd PRIVATE <boost/python.hpp> ${wrapping} <pxr/base/vt/wrapArray.h>
                <pxr/usd/usd/pyConversions.h> <pxr/usd/usd/relationship.h> <pxr/usd/usd/schemaBase.h>
                <pxr/usd/usd/stage.h>)
        elseif(library MATCHES "^usd." AND NOT library MATCHES "GL$|viewq$|AppUtils$")
            target_precompile_headers(${module} REUSE_FROM _usd)
        else()
            target_precompile_headers(${module} REUSE_FROM _tf)
        endif()
    endforeach()
endfunction()
cmake_language(DEFER DIRECTORY ${CMAKE_SOURCE_DIR} CALL _hdstf_tune_usdview)
