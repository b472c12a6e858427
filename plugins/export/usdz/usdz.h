#pragma once

#include <fresco/texturing/exports.h>

#include <functional>
#include <string>
#include <string_view>

/// \file Writes a textured mesh as a USD layer of text, which the stage puts into a USDZ package with its pictures (ZipWriter).

struct UsdaOptions
{
    std::string picture;    ///< Name of the picture in the package.
    bool lit;               ///< Lit, rough, not metallic, with smooth normals; otherwise black, emitting the picture.
    std::string normals{};  ///< Name of the normal map; empty, like the next: none.
    std::string roughness{};
};

/// Called with successive pieces of a text.
using WriteText = std::function<void(std::string_view)>;

/// A USD layer of one textured mesh as text (UTF-8), in meters, y up. The mesh is written unchanged, bit by bit; a
/// transform moves the middle of its box above the origin and its lowest point to the origin's level, to the millimeter, so that
/// phones put it on the floor. Pieces are about a megabyte.
void write_usda(const fresco::texturing::WeldedMesh& mesh, const UsdaOptions& options, const WriteText& write);
