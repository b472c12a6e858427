# fresco_add_processor_kinds(TARGET NAME.inl): compiles the inner loops in NAME.inl three times into TARGET: for any processor, for
# x86-64 with AVX2 and with AVX-512. NAME.inl defines the function FRESCO_KERNEL with vectors of FRESCO_VECTOR_BYTES; these are 0 where
# the compiler cannot make that kind. <fresco/parallel.h> takes the fastest that runs.
include(CheckCXXCompilerFlag)
set(FRESCO_PROCESSOR_KIND ${CMAKE_CURRENT_LIST_DIR}/processor_kind.cpp.in)

function(fresco_add_processor_kinds TARGET KERNEL_FILE)
    get_filename_component(name ${KERNEL_FILE} NAME_WE)
    get_filename_component(KERNEL ${KERNEL_FILE} NAME)
    get_filename_component(folder ${KERNEL_FILE} DIRECTORY)
    set(names_base "any processor")
    set(bytes_base 16)
    set(names_avx2 "AVX2")
    set(bytes_avx2 32)
    set(flags_avx2 -mavx2 -mfma)
    set(names_avx512 "AVX-512")
    set(bytes_avx512 64)
    set(flags_avx512 -mavx512f -mavx512bw -mavx512vl -mavx512dq -mprefer-vector-width=512)
    foreach(KIND base avx2 avx512)
        set(NAME ${names_${KIND}})
        set(BYTES ${bytes_${KIND}})
        set(flags ${flags_${KIND}})
        if(flags)
            string(REPLACE ";" " " tried "${flags}")
            if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
                check_cxx_compiler_flag("${tried}" FRESCO_COMPILES_${KIND})
            endif()
            if(NOT FRESCO_COMPILES_${KIND})
                set(BYTES 0)
                set(flags "")
            endif()
        endif()
        # GCC lays vectors of 64 bytes on AddressSanitizer's second stack as if it were aligned for them (GCC bug 110027).
        if(FRESCO_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
            list(APPEND flags --param=asan-use-after-return=0)
        endif()
        set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}_${KIND}.cpp)
        configure_file(${FRESCO_PROCESSOR_KIND} ${source} @ONLY)
        # Headers precompiled for another processor do not serve these.
        set_source_files_properties(${source} PROPERTIES
            COMPILE_OPTIONS "-O3;-ffp-contract=fast;-fno-math-errno;-Wno-psabi;${flags}"
            INCLUDE_DIRECTORIES ${CMAKE_CURRENT_SOURCE_DIR}/${folder}
            SKIP_PRECOMPILE_HEADERS ON)
        target_sources(${TARGET} PRIVATE ${source})
    endforeach()
endfunction()
