#pragma once

#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <vector>

/// V: the picture's color around each vertex: the mean, in linear light, of the texels of the faces around, each weighted by its
/// area on the surface and by how near it is to the vertex (its barycentric coordinate), sampled at every texel. Faces larger
/// than 256 texels are sampled 256 x 256 times. A vertex whose faces have no area takes the texel at its texcoord, one without
/// faces is gray. The mesh must have passed check_textured_mesh. Throws Canceled.
std::vector<fresco::Rgb8> vertex_colors(const fresco::TexturedMesh& textured, const fresco::Progress& progress);
