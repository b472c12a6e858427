# fresco_add_processor_kinds(NAME): NAME_base.cpp, NAME_avx2.cpp and NAME_avx512.cpp hold the same inner loops; each is compiled
# for its kind of processor, and the code beside them takes the fastest that runs.
include(CheckCXXCompilerFlag)

function(fresco_add_processor_kinds NAME)
    set(loops -O3 -ffp-contract=fast -Wno-psabi)
    set_property(SOURCE ${NAME}_base.cpp PROPERTY COMPILE_OPTIONS ${loops})
    # Headers precompiled for another processor do not serve these.
    set_property(SOURCE ${NAME}_base.cpp ${NAME}_avx2.cpp ${NAME}_avx512.cpp PROPERTY SKIP_PRECOMPILE_HEADERS ON)
    if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
        return()
    endif()
    set(flags_avx2 -mavx2 -mfma)
    set(flags_avx512 -mavx512f -mavx512bw -mavx512vl -mavx512dq -mprefer-vector-width=512)
    foreach(kind avx2 avx512)
        string(REPLACE ";" " " flags "${flags_${kind}}")
        check_cxx_compiler_flag("${flags}" FRESCO_COMPILES_${kind})
        if(FRESCO_COMPILES_${kind})
            set_property(SOURCE ${NAME}_${kind}.cpp PROPERTY COMPILE_OPTIONS ${loops} ${flags_${kind}})
        endif()
    endforeach()
endfunction()
