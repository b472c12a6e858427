#pragma once

#include <fresco/abi.h>

#include <version>

/// \file What FRESCO_STAGE, FRESCO_COMPONENT and FRESCO_LIBRARY expand to. The list they fill is private to each plugin (hidden
/// symbols, defined by the source file that fresco_add_plugin adds).

namespace fresco
{
class Configurable;
}

namespace fresco::detail
{

struct __attribute__((visibility("hidden"))) Registrar
{
    Registrar(int what, const char* type, const char* kind, const char* help, void* (*create)());
};

}  // namespace fresco::detail

#define FRESCO_DETAIL_JOIN2(a, b) a##b
#define FRESCO_DETAIL_JOIN(a, b) FRESCO_DETAIL_JOIN2(a, b)
#define FRESCO_DETAIL_REGISTER(what, type, kind, class_name, help)                                                               \
    static const ::fresco::detail::Registrar FRESCO_DETAIL_JOIN(fresco_registrar_, __COUNTER__){                                 \
        what, type, kind, help, []() -> void* { return static_cast<::fresco::Configurable*>(new class_name); }};

/// Names a library whose version decides results: `FRESCO_LIBRARY("OpenCV", CV_VERSION)`. It enters the cache key.
#define FRESCO_LIBRARY(name, version)                                                                                            \
    static const ::fresco::detail::Registrar FRESCO_DETAIL_JOIN(fresco_registrar_, __COUNTER__){FRESCO_ENTRY_LIBRARY, name,      \
                                                                                                "library", version, nullptr};

// Build properties of a library as text: host and plugins must agree before C++ objects cross between them.

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
