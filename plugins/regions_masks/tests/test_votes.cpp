#include "catch.h"
#include "votes.h"

#include <fresco/random.h>

#include <map>

using namespace fresco;
using raycast::Hit;

TEST_CASE("votes: a pixel is in the mask where it is bright in the mean")
{
    Raster8 mask(2, 1, 3);
    mask.values = {255, 255, 0, 255, 0, 0};
    CHECK(is_in_mask(mask, 0, 0));
    CHECK(!is_in_mask(mask, 1, 0));
}

TEST_CASE("votes: the winner is what counting pixel by pixel says")
{
    Random random(2);
    constexpr std::size_t faces = 40, regions = 3;
    constexpr int side = 20;
    Votes votes(regions, faces);
    std::map<std::pair<std::size_t, std::uint32_t>, std::pair<double, double>> counts;
    for (int picture = 0; picture < 5; ++picture)
    {
        std::vector<std::uint32_t> seen(side * side);
        for (std::uint32_t& face : seen)
        {
            face = static_cast<std::uint32_t>(random.uniform() * 50);
            face = face >= faces ? Hit::none : face;
        }
        const auto region = static_cast<std::size_t>(random.uniform() * regions);
        Raster8 mask(side, side, 1);
        for (std::uint8_t& value : mask.values)
            value = random.uniform() < 0.5 ? 255 : 0;
        votes.add(region, mask, seen);
        for (std::size_t i = 0; i < seen.size(); ++i)
            if (seen[i] != Hit::none)
            {
                counts[{region, seen[i]}].first += mask.values[i] != 0 ? 1 : 0;
                counts[{region, seen[i]}].second += 1;
            }
    }
    for (const double least : {0.2, 0.5, 0.6})
    {
        const auto winners = votes.winners(least);
        for (std::uint32_t face = 0; face < faces; ++face)
        {
            std::uint32_t expected = regions;
            double best = 0;
            bool is_seen = false;
            for (std::uint32_t region = 0; region < regions; ++region)
                if (const auto count = counts.find({region, face}); count != counts.end())
                {
                    is_seen = true;
                    const double share = count->second.first / count->second.second;
                    if (share >= least && share > best)
                    {
                        best = share;
                        expected = region;
                    }
                }
            CHECK(winners[face] == expected);
            CHECK(votes.is_seen(face) == is_seen);
        }
    }
}
