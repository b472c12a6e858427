#pragma once

#include <fresco/abi.h>

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
