#pragma once

#include <fresco/uv_maps.h>

#include <functional>
#include <span>
#include <vector>

namespace bench
{

/// A way to hold a uv map as bytes.
struct MapForm
{
    const char* name;
    std::function<std::vector<std::byte>(const fresco::UvMap&)> pack;
    std::function<fresco::UvMap(std::span<const std::byte>, int width, int height)> unpack;
    std::function<fresco::PackedUvMapBytes(std::span<const std::byte>)> bytes;
};

/// Raw floats; the plain way of 16 bits, gradient predictor, byte split and zstd at its own default level; ours.
const std::vector<MapForm>& map_forms();

}  // namespace bench
