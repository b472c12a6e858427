# The headers that most sources include, parsed once. Only for fresco's own build: plugins outside the tree never see them.
option(FRESCO_PRECOMPILED_HEADERS "Parse the headers that most sources include only once (ccache wants it off)" ON)

set(FRESCO_COMMON_HEADERS
    <fmt/format.h>
    <algorithm>
    <array>
    <cmath>
    <cstdint>
    <cstring>
    <filesystem>
    <functional>
    <limits>
    <map>
    <memory>
    <optional>
    <set>
    <span>
    <string>
    <string_view>
    <utility>
    <vector>)

# fresco_add_precompiled(KIND HEADERS header… [LINK target…] [PIC] [HIDDEN]): what fresco_use_precompiled(TARGET KIND) gives to targets
# that link the same. Compilers accept it only for sources of equal flags: PIC for code in shared libraries, HIDDEN for code that hides
# its symbols (a class keeps the visibility that it was parsed with).
function(fresco_add_precompiled KIND)
    cmake_parse_arguments(ARG "PIC;HIDDEN" "" "HEADERS;LINK" ${ARGN})
    if(NOT FRESCO_PRECOMPILED_HEADERS)
        return()
    endif()
    set(target fresco_precompiled_${KIND})
    set(source ${PROJECT_BINARY_DIR}/${target}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "")
    add_library(${target} OBJECT EXCLUDE_FROM_ALL ${source})
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ${ARG_PIC})
    if(ARG_HIDDEN)
        set_target_properties(${target} PROPERTIES CXX_VISIBILITY_PRESET hidden)
    endif()
    target_link_libraries(${target} PRIVATE fresco_compile_options ${ARG_LINK})
    target_precompile_headers(${target} PRIVATE ${ARG_HEADERS})
endfunction()

function(fresco_use_precompiled TARGET KIND)
    if(TARGET fresco_precompiled_${KIND})
        target_precompile_headers(${TARGET} REUSE_FROM fresco_precompiled_${KIND})
        # GCC 12 forgets of such headers that they are the system's, and sees in std::string's what is not there.
        target_compile_options(${TARGET} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>")
    endif()
endfunction()

# fresco_use_unity(TARGET): with FRESCO_UNITY its sources are compiled a dozen at a time, which is half the work of a build from scratch
# and more of it after a change. Names in their unnamed namespaces must differ. Sources with options of their own are compiled separately.
option(FRESCO_UNITY "Compile the sources of a library or test a dozen at a time (for builds from scratch)" OFF)
function(fresco_use_unity TARGET)
    set_target_properties(${TARGET} PROPERTIES UNITY_BUILD ${FRESCO_UNITY} UNITY_BUILD_BATCH_SIZE 12)
endfunction()
