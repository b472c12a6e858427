#include <fresco/geometry/flatten.h>
#include <fresco/numerics/numerics.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace
{

using namespace fresco::geometry;

/// Depth (uv) up to which faces may reach into each other by rounding: a hundredth of a texel of a 4096 texture.
constexpr double overlap_tolerance = 0.01 / 4096;

void check_texcoords(const fresco::Mesh& mesh)
{
    if (mesh.texcoords.empty())
        throw fresco::Error(
            "the mesh on port 'mesh' has no texture coordinates: use a mesh file that has them, or make an atlas with "
            "atlas.project");
    for (std::size_t c = 0; c < mesh.texcoords.size(); ++c)
    {
        const auto uv = mesh.texcoords[c];
        if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1))
            throw fresco::Error(fmt::format("face {} has the texture coordinate ({}, {}) outside [0,1]: the texture repeats or "
                                            "has several tiles; lay it out in one tile, or make an atlas with atlas.project",
                                            c / 3, uv.x, uv.y));
    }
}

/// The charts of texcoords that a mesh brings along: faces are in one chart if a path of edges connects them across which the
/// texcoords of both ends are equal. Numbered without gaps by first face.
std::vector<std::uint32_t> uv_charts(const fresco::Mesh& mesh)
{
    fresco::numerics::DisjointSets sets(mesh.triangles.size());
    const auto uv = [&](const EdgeUse& use, std::uint32_t end)
    { return mesh.texcoords[3 * std::size_t{use.face} + (use.corner + end) % 3]; };
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() == 2 && uses[0].forward != uses[1].forward && uv(uses[0], 0) == uv(uses[1], 1) &&
                          uv(uses[0], 1) == uv(uses[1], 0))
                          sets.join(uses[0].face, uses[1].face);
                  });
    return sets.numbers();
}

class AtlasKeep final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh with texture coordinates in [0,1]"};
    fresco::Output<fresco::Mesh> atlas{this, "atlas", "The same mesh with its own texture coordinates and their charts"};
    fresco::Option<int> size_px{this, "size_px", 2048, fresco::range(64, 16384),
                                "Texels per side of the texture: uv maps and what paints take it from the atlas"};

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "atlas.keep: input mesh");
        check_texcoords(*mesh);
        auto kept = *mesh;
        kept.charts = uv_charts(*mesh);
        kept.texture_px = *size_px;
        run.check_canceled();
        // Overlaps of all charts together, so that charts on top of each other are found too.
        Corners corners;
        for (const auto uv : mesh->texcoords)
            corners.push_back({static_cast<double>(uv.x), static_cast<double>(uv.y)});
        std::vector<std::uint32_t> faces(mesh->triangles.size());
        std::iota(faces.begin(), faces.end(), 0u);
        std::vector<bool> overlaps(faces.size(), false);
        for (const auto& [a, b] : find_overlaps(corners, faces, overlap_tolerance))
            overlaps[a] = overlaps[b] = true;
        double used = 0, overlapping = 0, mirrored = 0;
        for (std::size_t f = 0; f < faces.size(); ++f)
        {
            const double area = 0.5 * cross(corners[3 * f + 1] - corners[3 * f], corners[3 * f + 2] - corners[3 * f]);
            used += std::abs(area);
            overlapping += overlaps[f] ? std::abs(area) : 0;
            mirrored += area < 0 ? -area : 0;
        }
        const auto share = [&](double area) { return used > 0 ? area / used : 0; };
        run.report("charts", static_cast<std::int64_t>(*std::max_element(kept.charts.begin(), kept.charts.end())) + 1);
        run.report("used_share", used);
        run.report("overlap_share", share(overlapping));
        run.report("mirrored_share", share(mirrored));
        if (overlapping > 0)
            run.warning(fmt::format("faces with {:.1f} % of the atlas's area lie on other faces: these parts of the surface will "
                                    "show the same paint; atlas.project makes an atlas without overlaps",
                                    100 * share(overlapping)));
        atlas = std::move(kept);
    }
};

}  // namespace

FRESCO_STAGE("atlas.keep", AtlasKeep, "Keeps the mesh's own texture coordinates as its atlas")
