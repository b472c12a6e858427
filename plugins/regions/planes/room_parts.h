#pragma once

#include <fresco/geometry/charts.h>
#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

/// \file Divides a room into floor, ceiling, walls and furniture, for the stage. HeightGrid is a step of it,
/// declared for tests.

enum class RoomPart : std::uint8_t
{
    floor,
    ceiling,
    walls,
    furniture  ///< All other faces.
};
inline constexpr std::array<std::string_view, 4> room_part_names{"floor", "ceiling", "walls", "furniture"};

struct RoomParts
{
    std::vector<RoomPart> of_face;          ///< F
    std::vector<double> floor_heights_m;    ///< Heights of all levels, ascending; empty if none was found.
    std::vector<double> ceiling_heights_m;  ///< The lowest and the highest; empty if none was found.
    std::size_t wall_planes = 0;
};

/// Finds floor, ceiling and walls of a scanned room by its planes; README.md describes the method. z is up, meters.
/// The mesh must have passed check_mesh. The same for any number of threads. Throws Canceled.
RoomParts find_room_parts(const fresco::Mesh& upright, const fresco::Progress& progress);

/// Mean heights of roughly level surfaces in squares of cell_m; several per square if storeys lie above each other.
class HeightGrid
{
  public:
    static constexpr double cell_m = 0.1;

    void add(fresco::Vec3d point, double weight)
    {
        std::vector<Level>& cell = cells_[key(index(point.x), index(point.y))];
        for (Level& level : cell)
            if (std::abs(level.height() - point.z) < storey_m)
            {
                level.sum += point.z * weight;
                level.weight += weight;
                return;
            }
        if (weight > 0)
            cell.push_back({point.z * weight, weight});
    }

    /// The height in the nearest cell that has one, at most `cells` away from the point's; of equally near ones, the height that
    /// is nearest to the point's.
    std::optional<double> near(fresco::Vec3d point, int cells) const
    {
        const std::int64_t x = index(point.x);
        const std::int64_t y = index(point.y);
        std::optional<double> result;
        int nearest = 2 * cells * cells + 1;
        for (int dy = -cells; dy <= cells; ++dy)
            for (int dx = -cells; dx <= cells; ++dx)
            {
                const int distance = dx * dx + dy * dy;
                if (distance > nearest)
                    continue;
                const auto found = cells_.find(key(x + dx, y + dy));
                if (found == cells_.end())
                    continue;
                for (const Level& level : found->second)
                    if (distance < nearest || std::abs(level.height() - point.z) < std::abs(*result - point.z))
                    {
                        nearest = distance;
                        result = level.height();
                    }
            }
        return result;
    }

  private:
    static constexpr double storey_m = 1.5;

    struct Level
    {
        double sum = 0;
        double weight = 0;
        double height() const { return sum / weight; }
    };

    static std::int64_t index(double meters) { return std::llround(std::floor(meters / cell_m)); }
    static std::uint64_t key(std::int64_t x, std::int64_t y)
    {
        return (static_cast<std::uint64_t>(x) << 32U) ^ (static_cast<std::uint64_t>(y) & 0xffffffffU);
    }

    std::unordered_map<std::uint64_t, std::vector<Level>> cells_;
};
