#include <fresco/texturing/seam_links.h>

#include <algorithm>
#include <cmath>

namespace fresco::texturing
{

namespace
{
Vec2f between(const std::array<Vec2f, 2>& ends, float share)
{
    return ends[0] * (1 - share) + ends[1] * share;
}
}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> seam_links(const Charts& charts, const TexelFaces& faces)
{
    const auto chart_at = [&](std::size_t texel)
    { return faces.covered(texel) ? charts.of_face[faces.face[texel]] : TexelFaces::none; };

    std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
    for (const Seam& seam : charts.seams)
    {
        // Two steps per texel, so that no texel along the seam is stepped over.
        const float longer = std::max(length(seam.first[1] - seam.first[0]), length(seam.second[1] - seam.second[0]));
        const int steps = 1 + static_cast<int>(std::ceil(2 * longer * static_cast<float>(faces.size)));
        for (int i = 0; i < steps; ++i)
        {
            const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(steps);
            const std::size_t a = faces.at(between(seam.first, share));
            const std::size_t b = faces.at(between(seam.second, share));
            if (a == b || chart_at(a) != charts.of_face[seam.first_face] || chart_at(b) != charts.of_face[seam.second_face])
                continue;
            links.emplace_back(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
            links.emplace_back(static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(a));
        }
    }
    std::sort(links.begin(), links.end());
    links.erase(std::unique(links.begin(), links.end()), links.end());
    return links;
}

}  // namespace fresco::texturing
