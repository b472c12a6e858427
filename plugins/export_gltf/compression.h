#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file The streams of EXT_meshopt_compression, by meshoptimizer where the plugin was built with it.

/// Whether this build can compress; the other functions throw Error where it cannot.
bool can_compress();

/// Reorders triangles and vertices so that neighbors follow each other: the streams become smaller. The surface is the same.
void order_for_compression(fresco::texturing::WeldedMesh& mesh);

/// Mode ATTRIBUTES: `rows` holds whole rows of `stride` bytes, a multiple of 4 up to 256.
std::vector<std::byte> compressed_rows(std::span<const std::byte> rows, std::size_t stride);
/// Mode TRIANGLES. The corners of a triangle may come back turned: (a, b, c) as (b, c, a).
std::vector<std::byte> compressed_triangles(std::span<const std::uint32_t> indices, std::size_t vertices);

/// The reverse, checked: throws Error for streams that do not hold exactly so many rows or indices.
std::vector<std::byte> restored_rows(std::span<const std::byte> stream, std::size_t rows, std::size_t stride);
std::vector<std::uint32_t> restored_triangles(std::span<const std::byte> stream, std::size_t indices);
