#pragma once

/// \file What a library was compiled with, as text: host and plugins must agree before C++ objects cross between them.

#include <version>

#define FRESCO_STAMP_TEXT2(x) #x
#define FRESCO_STAMP_TEXT(x) FRESCO_STAMP_TEXT2(x)

// GCC and clang share one C++ ABI; what differs between major versions of one family is caught by the standard library's stamp.
#if defined(__clang__)
#define FRESCO_COMPILER_STAMP "clang " FRESCO_STAMP_TEXT(__clang_major__)
#elif defined(__GNUC__)
#define FRESCO_COMPILER_STAMP "gcc " FRESCO_STAMP_TEXT(__GNUC__)
#else
#error "fresco plugins need GCC or clang"
#endif

#if defined(_LIBCPP_VERSION)
#define FRESCO_STANDARD_LIBRARY_STAMP "libc++ " FRESCO_STAMP_TEXT(_LIBCPP_VERSION)
#else
#define FRESCO_STANDARD_LIBRARY_STAMP                                                                                            \
    "libstdc++ " FRESCO_STAMP_TEXT(_GLIBCXX_RELEASE) " cxx11abi=" FRESCO_STAMP_TEXT(_GLIBCXX_USE_CXX11_ABI)
#endif

#if defined(_GLIBCXX_DEBUG)
#define FRESCO_CONTAINERS_STAMP "debug"
#else
#define FRESCO_CONTAINERS_STAMP "release"
#endif
