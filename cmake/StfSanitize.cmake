# Sanitizers for the project's own code (docs/testing.md): address, undefined or thread, also "address;undefined".
# Libraries of others stay as they are; what of theirs disturbs is in sanitizers/*.supp, each line with its reason.
set(HDSTF_SANITIZE "" CACHE STRING "Sanitizers: address, undefined, thread, or address,undefined")
set_property(CACHE HDSTF_SANITIZE PROPERTY STRINGS "" address undefined thread address,undefined)

set(_sanitizers)
if(HDSTF_SANITIZE) # also OFF
    string(REPLACE "," ";" _sanitizers "${HDSTF_SANITIZE}")
endif()
foreach(_sanitizer IN LISTS _sanitizers)
    if(NOT _sanitizer MATCHES "^(address|undefined|thread)$")
        message(FATAL_ERROR "HDSTF_SANITIZE: \"${_sanitizer}\" is none of address, undefined and thread")
    endif()
endforeach()
if("thread" IN_LIST _sanitizers AND "address" IN_LIST _sanitizers)
    message(FATAL_ERROR "HDSTF_SANITIZE: address and thread cannot be had in one program")
endif()

add_library(stf_sanitize INTERFACE)
set(HDSTF_SANITIZER_ENVIRONMENT)
if(_sanitizers)
    list(JOIN _sanitizers "," _flag)
    target_compile_options(stf_sanitize INTERFACE -fsanitize=${_flag} -fno-omit-frame-pointer)
    target_link_options(stf_sanitize INTERFACE -fsanitize=${_flag})
    # What sanitizers add hides from GCC that values are set.
    target_compile_options(stf_sanitize INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    if("thread" IN_LIST _sanitizers)
        # OpenUSD's headers have fences, which are not followed; thread.supp names what comes of it.
        target_compile_options(stf_sanitize INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
    endif()
    if("undefined" IN_LIST _sanitizers)
        # A test that went on after undefined behaviour would pass.
        target_compile_options(stf_sanitize INTERFACE -fno-sanitize-recover=undefined)
    endif()
    set(HDSTF_SANITIZER_ENVIRONMENT
        TSAN_OPTIONS=suppressions=${CMAKE_CURRENT_LIST_DIR}/sanitizers/thread.supp:second_deadlock_stack=1)
    if("thread" IN_LIST _sanitizers)
        # OpenUSD hands work to threads of a TBB that ThreadSanitizer cannot see into: there it syncs prims one after another.
        list(APPEND HDSTF_SANITIZER_ENVIRONMENT PXR_WORK_THREAD_LIMIT=1)
    endif()
endif()
