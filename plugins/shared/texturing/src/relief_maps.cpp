#include <fresco/texturing/exports.h>
#include <fresco/texturing/relief_maps.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace fresco::texturing
{

namespace
{

/// Components along the frame that a renderer interpolates to the texel: it normalizes normal and tangent, and their product is
/// the third axis, so that the three need not be square to each other.
Vec3d in_frame(const WeldedMesh& welded, std::uint32_t face, const std::array<double, 3>& weights, Vec3d n)
{
    Vec3d normal;
    Vec3d tangent;
    double handed = 1;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const std::uint32_t v = welded.indices[3 * std::size_t{face} + i];
        normal += vec_cast<double>(welded.normals[v]) * weights[i];
        const auto& [x, y, z, w] = welded.tangents[v];
        tangent += Vec3d{double{x}, double{y}, double{z}} * weights[i];
        handed = double{w};
    }
    normal = normalized(normal);
    tangent = normalized(tangent);
    const Vec3d bitangent = cross(normal, tangent) * handed;
    const double volume = dot(tangent, cross(bitangent, normal));
    if (std::abs(volume) < 1e-6)
        return {0, 0, 1};
    return Vec3d{dot(n, cross(bitangent, normal)), dot(n, cross(normal, tangent)), dot(n, cross(tangent, bitangent))} *
           (1 / volume);
}

/// The texel whose face gives a texel its frame: itself if a face covers it, else its first covered neighbor, else
/// TexelFaces::none.
std::size_t framed(const TexelFaces& faces, std::size_t texel)
{
    const auto size = static_cast<std::size_t>(faces.size);
    const std::size_t x = texel % size, y = texel / size;
    if (faces.covered(texel))
        return texel;
    std::size_t found = TexelFaces::none;
    for (std::size_t row = y - (y > 0); row <= std::min(y + 1, size - 1); ++row)
        for (std::size_t column = x - (x > 0); column <= std::min(x + 1, size - 1); ++column)
            if (found == TexelFaces::none && faces.covered(row * size + column))
                found = row * size + column;
    return found;
}

/// At full size. `normal`(texel): the unit normal of a texel in a chart or just past its border. Only texels in charts fill the
/// gutter, because the normal past a border may belong to the other side of a sharp edge.
template <class Normal>
ReliefMaps maps_of(const Relief& relief, const std::vector<std::uint8_t>& in_chart, const std::vector<std::uint8_t>& past_border,
                   const Normal& normal, const Progress& progress)
{
    ReliefMaps maps{Raster8(relief.size_px(), relief.size_px(), 3), relief.roughness};
    const auto draw = [&](const std::vector<std::uint8_t>& texels)
    {
        constexpr std::size_t texels_per_block = 1U << 16U;
        parallel_items(texels.size(), texels_per_block, progress,
                       [&](std::size_t texel)
                       {
                           if (!texels[texel])
                               return;
                           const Vec3d n = normalized(normal(texel));
                           const auto step = [](double v) { return static_cast<std::uint8_t>(std::lround(127.5 * (v + 1))); };
                           const std::array steps{step(n.x), step(n.y), step(n.z)};
                           std::ranges::copy(steps, &maps.normals.values[3 * texel]);
                           maps.roughness.values[texel] = relief.roughness.values[texel];
                       });
    };
    draw(in_chart);
    fill_from_nearest(maps.normals, in_chart, progress);
    fill_from_nearest(maps.roughness, in_chart, progress);
    draw(past_border);
    return maps;
}

/// Texels average all known ones that have their centers in them.
Relief smaller(const Relief& relief, int size_px)
{
    const auto side = static_cast<std::size_t>(size_px), full = static_cast<std::size_t>(relief.size_px());
    std::vector<std::array<float, 5>> sums(side * side);  // Normal, roughness, count.
    for (std::size_t texel = 0; texel < full * full; ++texel)
        if (relief.has_normal(texel))
        {
            const auto to = [&](std::size_t v) { return (2 * v + 1) * side / (2 * full); };
            const Vec3f n = relief.normal(texel);
            const std::array added{n.x, n.y, n.z, static_cast<float>(relief.roughness.values[texel]), 1.0F};
            auto& sum = sums[to(texel / full) * side + to(texel % full)];
            for (std::size_t i = 0; i < added.size(); ++i)
                sum[i] += added[i];
        }
    Relief result;
    result.atlas = relief.atlas;
    result.normals = Raster16(size_px, size_px, 3);
    result.roughness = Raster8(size_px, size_px);
    for (std::size_t texel = 0; texel < sums.size(); ++texel)
        if (const auto& [x, y, z, roughness, count] = sums[texel]; count > 0)
        {
            const Vec3f n{x, y, z};
            if (!(length(n) > 0))
                continue;
            result.set_normal(texel, normalized(n));
            result.roughness.values[texel] = static_cast<std::uint8_t>(std::lround(roughness / count));
        }
    return result;
}

}  // namespace

ReliefMaps tangent_maps(const Relief& relief, const Mesh& mesh, int max_px, const Progress& progress)
{
    const Charts charts = find_charts(mesh);
    const TexelFaces faces = find_texel_faces(mesh, charts, relief.size_px(), progress);
    WeldedMesh welded = weld(mesh);
    add_tangents(welded);
    std::vector<std::uint8_t> in_chart(faces.face.size(), 0);
    std::vector<std::uint8_t> past_border(faces.face.size(), 0);
    for (std::size_t texel = 0; texel < in_chart.size(); ++texel)
        if (relief.has_normal(texel))
            (faces.inside[texel] ? in_chart : past_border)[texel] = framed(faces, texel) != TexelFaces::none;
    ReliefMaps maps = maps_of(
        relief, in_chart, past_border,
        [&](std::size_t texel)
        {
            const std::size_t frame = framed(faces, texel);
            return in_frame(welded, faces.face[frame], texel_weights(mesh, faces, frame), vec_cast<double>(relief.normal(texel)));
        },
        progress);
    if (max_px == 0 || max_px >= faces.size)
        return maps;
    const std::array full{std::move(maps.normals), std::move(maps.roughness)};
    auto smaller = smaller_pictures(mesh, charts, faces, full, max_px, progress, Steps::numbers);
    return {std::move(smaller[0]), std::move(smaller[1])};
}

ReliefMaps world_maps(const Relief& relief, int max_px, const Progress& progress)
{
    if (max_px > 0 && max_px < relief.size_px())
        return world_maps(smaller(relief, max_px), 0, progress);
    std::vector<std::uint8_t> known(relief.roughness.values.size());
    for (std::size_t texel = 0; texel < known.size(); ++texel)
        known[texel] = relief.has_normal(texel);
    return maps_of(
        relief, known, {}, [&](std::size_t texel) { return vec_cast<double>(relief.normal(texel)); }, progress);
}

}  // namespace fresco::texturing
