#include "compression.h"

#include <fresco/error.h>

#include <meshoptimizer.h>

#include <cstring>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
const unsigned char* raw(std::span<const std::byte> bytes)
{
    return reinterpret_cast<const unsigned char*>(bytes.data());
}

std::vector<std::byte> first_bytes(const std::vector<unsigned char>& bytes, std::size_t count)
{
    if (count == 0 || count > bytes.size())
        throw Error("meshoptimizer could not compress the mesh");
    std::vector<std::byte> result(count);
    std::memcpy(result.data(), bytes.data(), count);
    return result;
}

template <class T>
void reorder(std::vector<T>& values, const std::vector<unsigned>& remap)
{
    if (values.empty())
        return;
    std::vector<T> result(values.size());
    meshopt_remapVertexBuffer(result.data(), values.data(), values.size(), sizeof(T), remap.data());
    values = std::move(result);
}
}  // namespace

bool can_compress()
{
    return true;
}

void order_for_compression(WeldedMesh& mesh)
{
    const std::size_t vertices = mesh.positions.size();
    std::vector<unsigned> indices(mesh.indices.size());
    meshopt_optimizeVertexCacheStrip(indices.data(), mesh.indices.data(), mesh.indices.size(), vertices);
    std::vector<unsigned> remap(vertices);
    meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), vertices);
    meshopt_remapIndexBuffer(mesh.indices.data(), indices.data(), indices.size(), remap.data());
    reorder(mesh.positions, remap);
    reorder(mesh.normals, remap);
    reorder(mesh.texcoords, remap);
    reorder(mesh.colors, remap);
}

std::vector<std::byte> compressed_rows(std::span<const std::byte> rows, std::size_t stride)
{
    // The versions that EXT_meshopt_compression names.
    meshopt_encodeVertexVersion(0);
    std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(rows.size() / stride, stride));
    return first_bytes(stream,
                       meshopt_encodeVertexBuffer(stream.data(), stream.size(), rows.data(), rows.size() / stride, stride));
}

std::vector<std::byte> compressed_triangles(std::span<const std::uint32_t> indices, std::size_t vertices)
{
    meshopt_encodeIndexVersion(1);
    std::vector<unsigned char> stream(meshopt_encodeIndexBufferBound(indices.size(), vertices));
    return first_bytes(stream, meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(), indices.size()));
}

std::vector<std::byte> restored_rows(std::span<const std::byte> stream, std::size_t rows, std::size_t stride)
{
    // No stream holds more; and the decoder takes what it is told for granted.
    if (rows == 0 || rows / 256 > stream.size() || stride == 0 || stride > 256 || stride % 4 != 0)
        throw Error("a compressed stream of " + std::to_string(stream.size()) + " bytes cannot hold " + std::to_string(rows) +
                    " rows of " + std::to_string(stride) + " bytes");
    std::vector<std::byte> result(rows * stride);
    if (meshopt_decodeVertexBuffer(result.data(), rows, stride, raw(stream), stream.size()) != 0)
        throw Error("a compressed stream does not hold " + std::to_string(rows) + " rows of " + std::to_string(stride) +
                    " bytes");
    return result;
}

std::vector<std::uint32_t> restored_triangles(std::span<const std::byte> stream, std::size_t indices)
{
    if (indices == 0 || indices % 3 != 0 || indices / 3 > stream.size())
        throw Error("a compressed stream of " + std::to_string(stream.size()) + " bytes cannot hold " + std::to_string(indices) +
                    " indices of triangles");
    std::vector<std::uint32_t> result(indices);
    if (meshopt_decodeIndexBuffer(result.data(), indices, sizeof(std::uint32_t), raw(stream), stream.size()) != 0)
        throw Error("a compressed stream does not hold " + std::to_string(indices) + " indices");
    return result;
}
