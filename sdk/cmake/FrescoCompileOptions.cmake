# Options of fresco's own targets, as an interface target: nothing global, nothing imposed on users of the SDK. Their texts are
# formatted by fmt.
find_package(fmt REQUIRED)
fresco_tried(fmt "${fmt_VERSION}" 11)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    fresco_tried(GCC "${CMAKE_CXX_COMPILER_VERSION}" 15)
else()
    fresco_tried(Clang "${CMAKE_CXX_COMPILER_VERSION}" 20)
endif()
add_library(fresco_compile_options INTERFACE)
target_link_libraries(fresco_compile_options INTERFACE fmt::fmt)
target_compile_features(fresco_compile_options INTERFACE cxx_std_20)
# The prefix map keeps the build folder out of the libraries: rebuilding unchanged sources gives the same bytes anywhere.
target_compile_options(
    fresco_compile_options
    INTERFACE -Wall
              -Wextra
              -Wpedantic
              -Wshadow
              -Wconversion
              -Wnon-virtual-dtor
              -Woverloaded-virtual
              $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> # GCC 12 reports false overlaps in std::string's operator+ (its bug 105651)
              -ffile-prefix-map=${PROJECT_SOURCE_DIR}=.
              -ffile-prefix-map=${PROJECT_BINARY_DIR}=build
              -ffp-contract=off
              # Nothing reads errno or the floating-point flags after arithmetic; without them, the compiler may vectorize square roots and comparisons.
              -fno-math-errno
              -fno-trapping-math)
# As RPATH, not RUNPATH: so the program's counts for the libraries behind plugins too, and comes before LD_LIBRARY_PATH, in which a
# cluster's modules put other versions.
target_link_options(fresco_compile_options INTERFACE -Wl,--disable-new-dtags)
# On for developers, whose compilers are known: a newer one, or another level of optimization, brings false alarms. Through a file, so
# that turning it on or off compiles nothing again.
option(FRESCO_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
set(warning_options ${PROJECT_BINARY_DIR}/warning_options)
file(GENERATE OUTPUT ${warning_options} CONTENT "$<$<BOOL:${FRESCO_WARNINGS_AS_ERRORS}>:-Werror>\n")
target_compile_options(fresco_compile_options INTERFACE @${warning_options})
if(FRESCO_SANITIZE)
    # AddressSanitizer reports null pointers too, and their check is a third of the time of a build. GCC 12 takes the sanitizers' own
    # shadow variables for uninitialized ones.
    target_compile_options(fresco_compile_options INTERFACE -fsanitize=${FRESCO_SANITIZERS} -fno-sanitize=null -fno-sanitize-recover=all
                                                            -fno-omit-frame-pointer $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    target_link_options(fresco_compile_options INTERFACE -fsanitize=${FRESCO_SANITIZERS})
endif()
