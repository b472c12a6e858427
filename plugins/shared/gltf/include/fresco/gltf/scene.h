#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <tiny_gltf.h>
#include <utility>
#include <vector>

/// \file The nodes of a glTF scene and where they stand.

namespace fresco::gltf
{

/// A node's place: world = linear * p + origin.
struct Affine
{
    Mat3 linear;
    Vec3d origin;
};

Affine operator*(const Affine& a, const Affine& b);

/// The place of a node in its parent. Throws Error.
Affine place_of(const tinygltf::Node& node);

/// The places in a node of the copies of its mesh that EXT_mesh_gpu_instancing makes; without it, of the mesh itself. Throws
/// Error.
std::vector<Affine> copies_of(const tinygltf::Model& model, const tinygltf::Node& node);

/// Nodes of the scene, each once, in the order of the file's tree, with their places; without scenes those that are nobody's
/// children are its roots. Throws Error naming the node.
std::vector<std::pair<std::size_t, Affine>> placed_nodes(const tinygltf::Model& model);

}  // namespace fresco::gltf
