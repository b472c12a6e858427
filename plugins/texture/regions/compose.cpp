#include "compose.h"

#include <algorithm>

using namespace fresco;

std::vector<std::uint32_t> regions_of_texels(const texturing::TexelFaces& faces, const std::vector<std::uint16_t>& label_of_face)
{
    const int size = faces.size;
    // Neighbors at a side come before those at a corner.
    constexpr int around[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    std::vector<std::uint32_t> result(faces.face.size(), no_region);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const auto number = [&](int i, int j)
            { return static_cast<std::size_t>(j) * static_cast<std::size_t>(size) + static_cast<std::size_t>(i); };
            const std::size_t texel = number(x, y);
            if (faces.covered(texel))
            {
                result[texel] = label_of_face[faces.face[texel]];
                continue;
            }
            for (const auto& [dx, dy] : around)
                if (x + dx >= 0 && x + dx < size && y + dy >= 0 && y + dy < size && faces.covered(number(x + dx, y + dy)))
                {
                    result[texel] = label_of_face[faces.face[number(x + dx, y + dy)]];
                    break;
                }
        }
    return result;
}

KnownPicture composed(const KnownPicture& photo, const std::vector<std::uint32_t>& region_of_texel,
                      const std::vector<RegionRule>& rules)
{
    KnownPicture result = photo;
    for (std::size_t texel = 0; texel < region_of_texel.size(); ++texel)
    {
        if (region_of_texel[texel] == no_region)
        {
            result.is_known.values[texel] = 0;
            continue;
        }
        const RegionRule& rule = rules[region_of_texel[texel]];
        if (rule.painted == nullptr || rule.strength == 0)
            continue;
        const bool whole = rule.strength == 1;
        result.is_known.values[texel] = whole || photo.is_known.values[texel] != 0 ? rule.painted->is_known.values[texel] : 0;
        for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
        {
            const float from = photo.rgb.values[i];
            const float to = rule.painted->rgb.values[i];
            result.rgb.values[i] = whole ? to : std::clamp(from + rule.strength * (to - from), 0.0F, 1.0F);
        }
    }
    return result;
}
