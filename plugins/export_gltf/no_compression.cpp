#include "compression.h"

#include <fresco/error.h>

namespace
{
[[noreturn]] void refuse()
{
    throw fresco::Error("compression: meshopt: this build of export.gltf has no meshoptimizer: build it where that library is "
                        "(Debian: libmeshoptimizer-dev), or leave compression out");
}
}  // namespace

bool can_compress()
{
    return false;
}

void order_for_compression(fresco::texturing::WeldedMesh&)
{
    refuse();
}

std::vector<std::byte> compressed_rows(std::span<const std::byte>, std::size_t)
{
    refuse();
}

std::vector<std::byte> compressed_triangles(std::span<const std::uint32_t>, std::size_t)
{
    refuse();
}

std::vector<std::byte> restored_rows(std::span<const std::byte>, std::size_t, std::size_t)
{
    refuse();
}

std::vector<std::uint32_t> restored_triangles(std::span<const std::byte>, std::size_t)
{
    refuse();
}
