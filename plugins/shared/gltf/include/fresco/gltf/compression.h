#pragma once

#include <fresco/gltf/gltf_file.h>
#include <fresco/value.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

/// \file What glTF files pack vertices and triangles into: EXT_meshopt_compression and KHR_draco_mesh_compression.

namespace fresco::gltf
{

/// The rows or indices in a stream of meshoptimizer, filters undone. `form`: the extension's entry in a buffer view. Throws Error
/// beginning with `place` for a mode, filter or size that the extension does not define, and for a stream that does not hold what
/// the entry says.
std::vector<std::byte> meshopt_decoded(std::span<const std::byte> stream, const Value& form, const std::string& place);

/// Unpacks a primitive of KHR_draco_mesh_compression: its accessors then have views of buffers that are added to the model, and
/// its mode is triangles. `stream`: the bytes of the view that the extension's entry `form` names; what the entry leaves out
/// stays. Throws Error naming the byte of the stream or the accessor: a stream that is damaged, of another version than 2.2, or
/// that does not hold what the accessors say. Where the Draco library is missing, every primitive is refused that has no plain
/// form.
void unpack_draco(tinygltf::Model& model, tinygltf::Primitive& primitive, std::span<const std::byte> stream, const Value& form);

}  // namespace fresco::gltf
