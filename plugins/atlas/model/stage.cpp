#include <fresco/geometry/flatten.h>
#include <fresco/geometry/mesh_stages.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numeric>
#include <string>
#include <utility>

namespace
{

using namespace fresco::geometry;

/// Depth (uv) up to which faces may reach into each other by rounding: a hundredth of a texel of a 4096 texture.
constexpr double overlap_tolerance = 0.01 / 4096;

/// A share of the surface that may be without a place of its own: rounding.
constexpr double most_shared = 0.001;

enum class Uvs : std::uint8_t
{
    automatic,
    keep,
    second,
    fresh
};

/// Why a mesh's own texture coordinates cannot hold a painting; empty if they can, as far as single faces show.
std::string problem_of(const fresco::Mesh& mesh)
{
    if (mesh.texcoords.empty())
        return "the mesh has no texture coordinates";
    for (std::size_t c = 0; c < mesh.texcoords.size(); ++c)
    {
        const auto uv = mesh.texcoords[c];
        // A coordinate that rounding left beyond the border belongs to the last texel.
        const auto is_inside = [](float at) { return at >= -most_shared && at <= 1 + most_shared; };
        if (!is_inside(uv.x) || !is_inside(uv.y))
            return fmt::format(
                "face {} has the texture coordinate ({}, {}) outside [0,1], so the texture repeats or has several tiles", c / 3,
                uv.x, uv.y);
    }
    return "";
}

/// How the faces of an atlas share it.
struct AtlasShares
{
    double used = 0;         ///< Area in uv.
    double overlapping = 0;  ///< Share of it in faces that lie on other faces.
    double mirrored = 0;
    double missing = 0;  ///< Share of the surface whose faces have no area in uv.
};

AtlasShares shares_of(const fresco::Mesh& mesh)
{
    // Overlaps of all charts together, so that charts on top of each other are found too.
    Corners corners;
    for (const auto uv : mesh.texcoords)
        corners.push_back({static_cast<double>(uv.x), static_cast<double>(uv.y)});
    std::vector<std::uint32_t> faces(mesh.triangles.size());
    std::iota(faces.begin(), faces.end(), 0u);
    std::vector<bool> overlaps(faces.size(), false);
    for (const auto& [a, b] : find_overlaps(corners, faces, overlap_tolerance))
        overlaps[a] = overlaps[b] = true;
    AtlasShares shares;
    double surface = 0;
    for (const std::uint32_t f : faces)
    {
        const std::size_t first = 3 * std::size_t{f};
        const double area = 0.5 * cross(corners[first + 1] - corners[first], corners[first + 2] - corners[first]);
        const double on_surface = length(area_vector(mesh, f));
        surface += on_surface;
        shares.used += std::abs(area);
        shares.overlapping += overlaps[f] ? std::abs(area) : 0;
        shares.mirrored += area < 0 ? -area : 0;
        shares.missing += area == 0 ? on_surface : 0;
    }
    const auto divide = [](double& part, double whole) { part = whole > 0 ? part / whole : 0; };
    divide(shares.overlapping, shares.used);
    divide(shares.mirrored, shares.used);
    divide(shares.missing, surface);
    return shares;
}

class AtlasModel final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh as the model's file has it"};
    fresco::Input<fresco::Mesh> simplified{this, "simplified", fresco::optional, "The same surface decimated, for uvs: new"};
    fresco::Output<fresco::Mesh> atlas{this, "atlas", "The mesh with texture coordinates and their charts"};
    fresco::Choice<Uvs> uvs{this,
                            "uvs",
                            Uvs::automatic,
                            {{"auto", Uvs::automatic}, {"keep", Uvs::keep}, {"second", Uvs::second}, {"new", Uvs::fresh}},
                            "keep: the mesh's own texture coordinates; second: new ones for the same faces; new: new ones for "
                            "the decimated mesh; auto: "
                            "keep where the own ones lie in [0,1] without overlaps, else second"};
    fresco::Option<int> size_px{this, "size_px", 2048, fresco::range(64, 16384),
                                "Texels per side of the texture: uv maps and what paints take it from the atlas"};

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "the mesh on port 'mesh'");
        const bool may_keep = *uvs == Uvs::automatic || *uvs == Uvs::keep;
        std::string problem = may_keep ? problem_of(*mesh) : "";
        if (*uvs == Uvs::keep && !problem.empty())
            throw fresco::Error(problem + ": set uvs: second, which makes new ones for the same faces");
        AtlasShares shares;
        if (may_keep && problem.empty())
        {
            run.check_canceled();
            shares = shares_of(*mesh);
            if (shares.overlapping > most_shared)
                problem = fmt::format("faces with {:.1f} % of the texture's area lie on other faces", 100 * shares.overlapping);
            else if (shares.missing > most_shared)
                problem = fmt::format("{:.1f} % of the surface has no place in the texture", 100 * shares.missing);
        }
        if (may_keep && (problem.empty() || *uvs == Uvs::keep))
        {
            keep(shares, run);
            if (!problem.empty())
                run.warning(problem + ": these parts will show the same paint; uvs: second makes new texture coordinates");
            return;
        }
        if (!problem.empty())
            run.message(problem + ": the model gets new texture coordinates beside its own");
        const fresco::Mesh& laid_out = *uvs == Uvs::fresh && simplified.has_value() ? *simplified : *mesh;
        fresco::check_mesh(laid_out, "the mesh to lay out");
        atlas = projected_atlas(laid_out, {.size_px = *size_px}, run);
        run.report("kept", false);
    }

    void keep(const AtlasShares& shares, fresco::RunContext& run)
    {
        auto kept = *mesh;
        auto charts = fresco::texturing::find_charts(kept);
        kept.charts = std::move(charts.of_face);
        kept.texture_px = *size_px;
        run.report("kept", true);
        run.report("charts", std::size_t{charts.count});
        run.report("used_share", shares.used);
        run.report("overlap_share", shares.overlapping);
        run.report("mirrored_share", shares.mirrored);
        atlas = std::move(kept);
    }
};

}  // namespace

FRESCO_STAGE("atlas.model", AtlasModel, "Lays out a model: keeps its own texture coordinates where they can hold a painting")
