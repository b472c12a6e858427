# fresco_add_plugin(NAME
#     SOURCES file…          the stage or component: the thin part that registers itself
#     [ALGORITHMS file…]     pure code beside it: a static library NAME_core, used by the plugin and by its tests
#     [LINK target…]         libraries behind it
#     [TORCH]                speaks tensors: links fresco::sdk_torch
#     [TESTS file…]          Catch2 cases: an executable test_NAME and a test of that name
#     [TEST_LINK target…])
# In the tree and outside it (after find_package(fresco)) the same call. The library is NAME.so, in lib/fresco.
#
# fresco_add_algorithms(NAME SOURCES file… [LINK target…] [TESTS file…]) makes a static library of pure code alone, for a plugin
# to LINK: what is to be tested where the plugin itself cannot be built. Its folder is an include directory; TESTS become the
# test test_NAME.
#
# fresco_add_artifact(NAME SOURCES file… [LINK target…]) makes the shared library of an artifact type; its producers and
# consumers link it. Its folder is an include directory for them.

set(FRESCO_PLUGIN_ENTRY_SOURCE ${CMAKE_CURRENT_LIST_DIR}/plugin_entry.cpp)
set(FRESCO_TEST_MAIN_SOURCE ${CMAKE_CURRENT_LIST_DIR}/test_main.cpp)

macro(_fresco_own_options target)
    target_compile_features(${target} PUBLIC cxx_std_20)
    if(NOT CMAKE_INSTALL_RPATH)
        # Installed, it finds fresco's libraries beside itself, one folder up, or where it was linked with them.
        set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN;$ORIGIN/.." INSTALL_RPATH_USE_LINK_PATH ON)
    endif()
    if(TARGET fresco_compile_options)
        target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:fresco_compile_options>)
    else()
        target_compile_options(${target} PRIVATE -ffile-prefix-map=${CMAKE_SOURCE_DIR}=. -ffp-contract=off)
    endif()
endmacro()

function(fresco_add_plugin NAME)
    cmake_parse_arguments(ARG "TORCH" "" "SOURCES;ALGORITHMS;LINK;TESTS;TEST_LINK" ${ARGN})
    if(ARG_UNPARSED_ARGUMENTS OR NOT ARG_SOURCES)
        message(FATAL_ERROR "fresco_add_plugin(${NAME}): SOURCES missing or unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
    endif()
    if(ARG_TORCH)
        if(NOT TARGET fresco::sdk_torch)
            message(STATUS "Plugin ${NAME} is left out: libtorch was not found")
            return()
        endif()
        set(sdk fresco::sdk_torch)
    else()
        set(sdk fresco::sdk)
    endif()

    add_library(${NAME} MODULE ${ARG_SOURCES} ${FRESCO_PLUGIN_ENTRY_SOURCE})
    set_target_properties(${NAME} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN OFF)
    if(FRESCO_PLUGIN_OUTPUT_DIRECTORY)
        set_target_properties(${NAME} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${FRESCO_PLUGIN_OUTPUT_DIRECTORY})
    endif()
    target_link_libraries(${NAME} PRIVATE ${sdk} ${ARG_LINK})
    if(ARG_TORCH)
        target_compile_definitions(${NAME} PRIVATE FRESCO_PLUGIN_USES_TORCH)
    endif()
    _fresco_own_options(${NAME})

    if(ARG_ALGORITHMS)
        fresco_add_algorithms(${NAME}_core SOURCES ${ARG_ALGORITHMS} LINK ${sdk} ${ARG_LINK})
        target_link_libraries(${NAME} PRIVATE ${NAME}_core)
    endif()

    if(ARG_TESTS AND BUILD_TESTING)
        fresco_add_test(test_${NAME} SOURCES ${ARG_TESTS} LINK ${sdk} ${ARG_LINK} ${ARG_TEST_LINK})
        target_include_directories(test_${NAME} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
        target_compile_definitions(test_${NAME} PRIVATE FRESCO_PLUGIN_FILE="$<TARGET_FILE:${NAME}>")
        add_dependencies(test_${NAME} ${NAME})
        if(ARG_ALGORITHMS)
            target_link_libraries(test_${NAME} PRIVATE ${NAME}_core)
        endif()
    endif()
    install(TARGETS ${NAME} LIBRARY DESTINATION lib/fresco)
endfunction()

function(fresco_add_algorithms NAME)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK;TESTS" ${ARGN})
    if(ARG_UNPARSED_ARGUMENTS OR NOT ARG_SOURCES)
        message(FATAL_ERROR "fresco_add_algorithms(${NAME}): SOURCES missing or unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
    endif()
    add_library(${NAME} STATIC ${ARG_SOURCES})
    set_target_properties(${NAME} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_include_directories(${NAME} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${NAME} PUBLIC ${ARG_LINK})
    _fresco_own_options(${NAME})
    if(COMMAND fresco_use_precompiled)
        if("fresco::sdk_torch" IN_LIST ARG_LINK)
            fresco_use_precompiled(${NAME} torch)
        else()
            fresco_use_precompiled(${NAME} sdk)
        endif()
    endif()
    if(ARG_TESTS AND BUILD_TESTING)
        fresco_add_test(test_${NAME} SOURCES ${ARG_TESTS} LINK ${NAME})
    endif()
endfunction()

function(fresco_add_artifact NAME)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_library(${NAME} SHARED ${ARG_SOURCES})
    target_include_directories(${NAME} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}>)
    target_link_libraries(${NAME} PUBLIC fresco::sdk ${ARG_LINK})
    _fresco_own_options(${NAME})
    install(TARGETS ${NAME} LIBRARY DESTINATION lib)
endfunction()

# fresco_add_test(NAME SOURCES file… [LINK target…]): a Catch2 executable with its main, run by ctest.
function(fresco_add_test NAME)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_executable(${NAME} ${ARG_SOURCES})
    target_link_libraries(${NAME} PRIVATE ${ARG_LINK})
    if(TARGET fresco_test_main)
        target_link_libraries(${NAME} PRIVATE fresco_test_main)
        set_target_properties(${NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests BUILD_WITH_INSTALL_RPATH OFF)
    else()
        find_package(Catch2 2 REQUIRED)
        target_sources(${NAME} PRIVATE ${FRESCO_TEST_MAIN_SOURCE})
        target_link_libraries(${NAME} PRIVATE Catch2::Catch2)
    endif()
    _fresco_own_options(${NAME})
    if(COMMAND fresco_use_precompiled)
        if("fresco::sdk_torch" IN_LIST ARG_LINK)
            fresco_use_precompiled(${NAME} torch_tests)
        else()
            fresco_use_precompiled(${NAME} tests)
        endif()
    endif()
    add_test(NAME ${NAME} COMMAND ${NAME})
endfunction()
