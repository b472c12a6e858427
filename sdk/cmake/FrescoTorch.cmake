# fresco_find_torch([HINT folder]): libtorch, any from 1.13 on, as the target fresco::libtorch; sets FRESCO_TORCH_FOUND and, where
# it was found, FRESCO_TORCH_ROOT, the folder above its include/. Looked for in Torch_DIR, Torch_ROOT, CMAKE_PREFIX_PATH (the
# package's folder, or what torch.utils.cmake_prefix_path says), HINT, and where the system has its libraries. A libtorch whose
# standard library has the other C++ ABI is refused.
#
# Not by find_package(Torch): that of a libtorch for CUDA stops unless it finds CUDA's compiler, the same version of its headers,
# nvToolsExt (which CUDA has no more) and others that nothing here includes or links, and a machine that only runs CUDA has none of.

include(CheckCXXSourceCompiles)

# Whether `library` speaks of std::string with the ABI that the compiler at hand uses.
function(_fresco_check_torch_abi library)
    file(STRINGS ${library} errors REGEX "_ZN3c105ErrorC")
    if(NOT errors)
        return()
    endif()
    unset(FRESCO_COMPILES_CXX11_ABI CACHE)  # The flags may have changed since.
    check_cxx_source_compiles("#include <string>\n#if !_GLIBCXX_USE_CXX11_ABI\n#error old\n#endif\nint main() {}" FRESCO_COMPILES_CXX11_ABI)
    if(errors MATCHES "__cxx11")
        set(built 1)
    else()
        set(built 0)
    endif()
    if(FRESCO_COMPILES_CXX11_ABI)
        set(here 1)
    else()
        set(here 0)
    endif()
    if(NOT built EQUAL here)
        message(FATAL_ERROR "${library} was built with _GLIBCXX_USE_CXX11_ABI=${built}, and this build has ${here}: their strings differ. "
                            "Take a libtorch with the C++11 ABI, or configure with -DCMAKE_CXX_FLAGS=-D_GLIBCXX_USE_CXX11_ABI=${built}")
    endif()
endfunction()

function(fresco_find_torch)
    cmake_parse_arguments(ARG "" "HINT" "" ${ARGN})
    if(TARGET fresco::libtorch)
        set(FRESCO_TORCH_FOUND ON PARENT_SCOPE)
        return()
    endif()
    set(hints)
    if(Torch_DIR)
        list(APPEND hints ${Torch_DIR}/../../..)
    endif()
    list(APPEND hints ${Torch_ROOT} $ENV{Torch_ROOT})
    foreach(prefix IN LISTS CMAKE_PREFIX_PATH)
        list(APPEND hints ${prefix} ${prefix}/../..)
    endforeach()
    set(api torch/csrc/api/include)
    find_path(FRESCO_TORCH_API torch/version.h HINTS ${hints} ${ARG_HINT} PATH_SUFFIXES include/${api} ${api})
    set(FRESCO_TORCH_FOUND OFF PARENT_SCOPE)
    if(NOT FRESCO_TORCH_API)
        return()
    endif()
    get_filename_component(include ${FRESCO_TORCH_API}/../../../.. ABSOLUTE)
    get_filename_component(root ${include}/.. ABSOLUTE)
    foreach(library torch_cpu c10)
        find_library(FRESCO_LIB_${library} ${library} HINTS ${root}/lib)
        mark_as_advanced(FRESCO_LIB_${library})
        if(NOT FRESCO_LIB_${library})
            return()
        endif()
    endforeach()
    mark_as_advanced(FRESCO_TORCH_API)
    get_filename_component(folder ${FRESCO_LIB_torch_cpu} DIRECTORY)
    _fresco_check_torch_abi(${FRESCO_LIB_c10})

    set(libraries ${FRESCO_LIB_torch_cpu} ${FRESCO_LIB_c10})
    # Debian's of 1.13 logs through these, from inline functions of its headers.
    file(STRINGS ${include}/c10/macros/cmake_macros.h loggers REGEX "^#define C10_USE_(GLOG|GFLAGS)")
    foreach(logger IN LISTS loggers)
        string(REGEX REPLACE "^#define C10_USE_([A-Z]+).*" "\\1" logger ${logger})
        string(TOLOWER ${logger} logger)
        find_library(FRESCO_LIB_${logger} ${logger} HINTS ${root}/lib REQUIRED)
        mark_as_advanced(FRESCO_LIB_${logger})
        list(APPEND libraries ${FRESCO_LIB_${logger}})
    endforeach()
    set(kind "CPU")
    set(cuda "")
    if(EXISTS ${folder}/libtorch_cuda.so)
        # The major version, within which CUDA's libraries are exchangeable, as the loader knows it.
        file(STRINGS ${folder}/libc10_cuda.so runtimes REGEX "^libcudart[^ ]*\\.so\\.[0-9]+")
        string(REGEX MATCH "\\.so\\.([0-9]+)" whole "${runtimes}")
        set(cuda "${CMAKE_MATCH_1}")
        set(kind "CUDA ${cuda}")
        # Nothing calls it by name: it makes itself known when it is loaded. What it needs in turn it finds by itself.
        foreach(library torch_cuda c10_cuda)
            list(APPEND libraries "-Wl,--push-state,--no-as-needed,${folder}/lib${library}.so,--pop-state")
        endforeach()
        list(APPEND libraries "-Wl,--allow-shlib-undefined")
    endif()
    set(definitions "FRESCO_TORCH_CUDA=\"${cuda}\"")
    if(EXISTS ${include}/fmt/format.h)
        # PyTorch's headers bring a fmt of their own, which is found before the system's, whose library has another version.
        list(APPEND definitions FMT_HEADER_ONLY)
    endif()
    add_library(fresco::libtorch INTERFACE IMPORTED GLOBAL)
    # System headers: their warnings are not ours.
    set_target_properties(fresco::libtorch PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${include};${FRESCO_TORCH_API}"
                                                      INTERFACE_INCLUDE_DIRECTORIES "${include};${FRESCO_TORCH_API}"
                                                      INTERFACE_COMPILE_DEFINITIONS "${definitions}"
                                                      INTERFACE_LINK_LIBRARIES "${libraries}")
    set(FRESCO_TORCH_FOUND ON PARENT_SCOPE)
    set(FRESCO_TORCH_ROOT ${root} PARENT_SCOPE)
    if(NOT "${FRESCO_TORCH_TOLD}" STREQUAL "${root}")
        message(STATUS "Found libtorch (${kind}): ${FRESCO_LIB_torch_cpu}")
        set(FRESCO_TORCH_TOLD ${root} CACHE INTERNAL "")
    endif()
endfunction()
