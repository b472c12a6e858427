#pragma once

#include <fresco/value.h>

#include <string>
#include <string_view>

/// The two chunks of a GLB.
struct GlbParts
{
    fresco::Value document;
    std::string_view binary;  ///< Of the file that was taken apart.
};

/// Throws Error naming the offset.
GlbParts parts_of(std::string_view glb);

/// A GLB of these chunks; `binary` has a multiple of four bytes.
std::string assembled(const fresco::Value& document, std::string_view binary);
