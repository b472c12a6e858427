#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tinygltf
{
class Model;
}

namespace fresco::gltf
{

/// The rows of an accessor, checked to lie inside of their view.
struct AccessorRows
{
    const unsigned char* first = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;
    std::size_t components = 0;
    int component_type = 0;
    bool normalized = false;

    /// The number, from 0 to 1 (-1 to 1 if signed) for normalized integers.
    double at(std::size_t row, std::size_t component) const;
    std::uint32_t integer_at(std::size_t row) const;
};

/// Throws Error naming the accessor: one that does not exist, is sparse or without a view, has other than `least` to `most`
/// components, or does not fit its view.
AccessorRows accessor_rows(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most);

/// The triangles of a primitive: three numbers each. `indices` < 0: the vertices in their order. Strips and fans are taken apart;
/// lines and points give none. Throws Error for an index that is not below `vertex_count`.
std::vector<std::uint32_t> triangle_indices(const tinygltf::Model& model, int indices, int mode, std::size_t vertex_count);

}  // namespace fresco::gltf
