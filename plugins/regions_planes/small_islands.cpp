#include "small_islands.h"

#include <algorithm>
#include <array>

using fresco::geometry::none;

void absorb_small_islands(const fresco::geometry::Surface& surface, std::vector<RoomPart>& of_face)
{
    constexpr double island_m2 = 0.02;
    constexpr double most_of_border = 0.6;
    const std::vector<RoomPart> before = of_face;
    std::vector<std::uint8_t> visited(of_face.size(), 0);
    std::vector<std::uint32_t> piece;
    for (std::uint32_t seed = 0; seed < before.size(); ++seed)
    {
        if (visited[seed])
            continue;
        piece.assign(1, seed);
        visited[seed] = 1;
        double area = 0;
        std::array<std::size_t, room_part_names.size()> border{};
        for (std::size_t next = 0; next < piece.size(); ++next)
        {
            area += surface.areas[piece[next]];
            for (const std::uint32_t g : surface.neighbors[piece[next]])
            {
                if (g == none)
                    continue;
                if (before[g] != before[seed])
                    ++border[static_cast<std::size_t>(before[g])];
                else if (!visited[g])
                {
                    visited[g] = 1;
                    piece.push_back(g);
                }
            }
        }
        std::size_t edges = 0;
        for (const std::size_t count : border)
            edges += count;
        const auto most = std::ranges::max_element(border);
        if (area < island_m2 && edges > 0 && static_cast<double>(*most) >= most_of_border * static_cast<double>(edges))
            for (const std::uint32_t f : piece)
                of_face[f] = static_cast<RoomPart>(most - border.begin());
    }
}
