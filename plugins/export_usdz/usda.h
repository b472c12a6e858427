#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <functional>
#include <string>
#include <string_view>

struct UsdaOptions
{
    std::string picture;  ///< Name of the picture in the package.
    bool lit;             ///< Lit, rough, not metallic, with smooth normals; otherwise black, emitting the picture.
};

/// Called with a text piece by piece.
using WritePiece = std::function<void(std::string_view)>;

/// A USD layer of one textured mesh as text (UTF-8), in meters, y up. The mesh is written as it is, bit by bit; it is moved so
/// that the middle of its box is above the origin and its lowest point level with it, to the millimeter: where a phone puts it on
/// the floor. Pieces are of about a megabyte.
void write_usda(const fresco::texturing::WeldedMesh& mesh, const UsdaOptions& options, const WritePiece& write);
