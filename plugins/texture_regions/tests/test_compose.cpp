#include "catch.h"
#include "compose.h"
#include <fresco/testing_scenes.h>

#include <fresco/random.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{

KnownPicture random_picture(int side, std::uint64_t seed)
{
    Random random(seed);
    KnownPicture picture{RasterF(side, side, 3), Raster8(side, side)};
    for (float& value : picture.rgb.values)
        value = static_cast<float>(random.uniform() * 1.2 - 0.1);
    for (std::uint8_t& known : picture.is_known.values)
        known = random.uniform() < 0.5 ? 1 : 0;
    return picture;
}

}  // namespace

TEST_CASE("compose: every texel is what its region's rule says, kept ones bit for bit")
{
    constexpr int side = 24;
    const KnownPicture photo = random_picture(side, 1);
    const KnownPicture night = random_picture(side, 2);
    const KnownPicture waves = random_picture(side, 3);
    const std::vector<RegionRule> rules{{}, {&night, 0.7F}, {&waves, 1}, {&night, 0}};
    Random random(4);
    std::vector<std::uint32_t> regions(photo.is_known.values.size());
    for (std::uint32_t& region : regions)
    {
        region = static_cast<std::uint32_t>(random.uniform() * 5);
        region = region == 4 ? no_region : region;
    }
    const KnownPicture result = composed(photo, regions, rules);
    for (std::size_t texel = 0; texel < regions.size(); ++texel)
    {
        const auto known = [&](const KnownPicture& picture) { return picture.is_known.values[texel]; };
        const std::uint32_t region = regions[texel];
        CHECK(known(result) == (region == no_region ? 0
                                : region == 1       ? known(photo) * known(night)
                                : region == 2       ? known(waves)
                                                    : known(photo)));
        for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
        {
            const float p = photo.rgb.values[i];
            if (region == 1)
                CHECK(result.rgb.values[i] == std::min(1.0F, std::max(0.0F, p + 0.7F * (night.rgb.values[i] - p))));
            else
                CHECK(result.rgb.values[i] == (region == 2 ? waves.rgb.values[i] : p));
        }
    }
}

TEST_CASE("compose: a texel belongs to its face's region, one beside a chart to that of a neighbor, none beyond")
{
    const Mesh mesh = testing::two_chart_wall();
    const texturing::Charts charts = texturing::find_charts(mesh);
    constexpr int side = 40;
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, charts, side, Progress{});
    const std::vector<std::uint16_t> labels{0, 0, 1, 2};
    const auto regions = regions_of_texels(faces, labels);
    std::size_t beside = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
        {
            const auto texel = static_cast<std::size_t>(y * side + x);
            if (faces.covered(texel))
            {
                CHECK(regions[texel] == labels[faces.face[texel]]);
                continue;
            }
            bool near = false;
            bool same = false;
            for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side - 1); ++j)
                for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side - 1); ++i)
                    if (const auto other = static_cast<std::size_t>(j * side + i); faces.covered(other))
                    {
                        near = true;
                        same = same || regions[texel] == labels[faces.face[other]];
                    }
            CHECK((regions[texel] == no_region) == !near);
            CHECK(same == near);
            beside += near ? 1 : 0;
        }
    CHECK(beside > 50);
}
