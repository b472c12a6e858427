#include "crumb_patch.h"

#include <array>

namespace fresco::geometry
{
namespace
{

/// What is larger is no noise and stays as it is.
constexpr double joined_texels = 512;
/// Charts that are tried for each crumb, those of the longest common borders.
constexpr std::size_t tried_charts = 2;
/// How far the chart gives way, in faces: as little as will do.
constexpr std::array<int, 2> tried_steps{2, 5};
constexpr int joining_sweeps = 40;
/// Largest L² stretch of a patch (Sander et al. 2001), squared.
constexpr double largest_patch_stretch = 10;

class Joiner
{
  public:
    Joiner(const Surface& surface, FlatCharts& flat, double texel_m)
        : charts_(surface, flat), patches_(charts_), limits_{.area_m2 = joined_texels * texel_m * texel_m},
          tolerance_m_(1e-3 * texel_m), in_patch_(surface.areas.size(), false)
    {
    }

    std::size_t run(const Progress& progress)
    {
        std::size_t joined = 0;
        for (const auto crumb : charts_.crumbs(limits_))
        {
            progress.check_canceled();
            // It may have grown by others, or be gone.
            if (charts_.is_crumb(crumb, limits_) && join(crumb))
                ++joined;
        }
        return joined;
    }

  private:
    bool join(std::uint32_t crumb)
    {
        const auto neighbors = charts_.neighbors(crumb);
        for (std::size_t i = 0; i < std::min(neighbors.size(), tried_charts); ++i)
            for (const int steps : tried_steps)
                for (const bool contracted : {false, true})
                {
                    auto patch = patches_.make(crumb, neighbors[i], steps);
                    if (!patch)
                        continue;
                    if (contracted)
                        contract(*patch);
                    if (!lies_well(relax(patch->shape, joining_sweeps)))
                        continue;
                    const auto corners = corners_of(patch->shape);
                    if (overlaps(*patch, corners, neighbors[i]))
                        continue;
                    for (std::size_t f = 0; f < patch->faces.size(); ++f)
                        charts_.lay(patch->faces[f], neighbors[i], std::span(corners).subspan(3 * f).first<3>());
                    charts_.dissolve(crumb, neighbors[i]);
                    return true;
                }
        return false;
    }

    static bool lies_well(const PatchFigures& figures)
    {
        return figures.least_area_share >= smallest_area_share && figures.square_stretch <= largest_patch_stretch;
    }

    static Corners corners_of(const FlatPatch& shape)
    {
        Corners corners;
        corners.reserve(3 * shape.triangles.size());
        for (const auto& t : shape.triangles)
            for (const auto v : t)
                corners.push_back(shape.places[v]);
        return corners;
    }

    /// Of the patch with itself, or with the rest of the chart.
    bool overlaps(const CrumbPatch& patch, const Corners& corners, std::uint32_t chart)
    {
        std::vector<std::uint32_t> all(patch.faces.size());
        std::iota(all.begin(), all.end(), 0u);
        if (!find_overlaps(corners, all, tolerance_m_).empty())
            return true;
        for (const auto f : patch.faces)
            in_patch_[f] = true;
        bool found = false;
        for (std::size_t f = 0; f < patch.faces.size() && !found; ++f)
            found = charts_.covered(chart, std::span(corners).subspan(3 * f).first<3>(), tolerance_m_,
                                    [&](std::uint32_t face) { return !in_patch_[face]; });
        for (const auto f : patch.faces)
            in_patch_[f] = false;
        return found;
    }

    MovingCharts charts_;
    PatchMaker patches_;
    CrumbLimits limits_;
    double tolerance_m_;
    std::vector<bool> in_patch_;
};

}  // namespace

std::size_t join_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress)
{
    return Joiner(surface, flat, texel_m).run(progress);
}

}  // namespace fresco::geometry
