#include "room_parts.h"

#include "plane_segments.h"

#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <unordered_map>

using fresco::geometry::none;
using namespace fresco;

namespace
{

using Border = std::array<std::size_t, room_part_names.size()>;

/// Calls `each(part, faces, area, border)` for every connected piece of one part; `border` counts its edges by the part beyond.
template <class F>
void for_each_piece(const geometry::Surface& surface, const std::vector<RoomPart>& of_face, F&& each)
{
    std::vector<std::uint8_t> visited(of_face.size(), 0);
    std::vector<std::uint32_t> piece;
    for (std::uint32_t seed = 0; seed < of_face.size(); ++seed)
    {
        if (visited[seed])
            continue;
        piece.assign(1, seed);
        visited[seed] = 1;
        double area = 0;
        Border border{};
        for (std::size_t next = 0; next < piece.size(); ++next)
        {
            area += surface.areas[piece[next]];
            for (const std::uint32_t g : surface.neighbors[piece[next]])
            {
                if (g == none)
                    continue;
                if (of_face[g] != of_face[seed])
                    ++border[static_cast<std::size_t>(of_face[g])];
                else if (!visited[g])
                {
                    visited[g] = 1;
                    piece.push_back(g);
                }
            }
        }
        each(of_face[seed], piece, area, border);
    }
}

/// Reassigns connected pieces of one part that are smaller than a hand (switches, handles, noise) to the part that most of their
/// border touches.
void absorb_small_islands(const geometry::Surface& surface, std::vector<RoomPart>& of_face)
{
    constexpr double island_m2 = 0.02;
    constexpr double most_of_border = 0.6;
    const std::vector<RoomPart> before = of_face;
    for_each_piece(surface, before,
                   [&](RoomPart, const std::vector<std::uint32_t>& piece, double area, const Border& border)
                   {
                       const std::size_t edges = std::accumulate(border.begin(), border.end(), std::size_t{0});
                       const auto most = std::ranges::max_element(border);
                       if (area < island_m2 && edges > 0 &&
                           static_cast<double>(*most) >= most_of_border * static_cast<double>(edges))
                           for (const std::uint32_t f : piece)
                               of_face[f] = static_cast<RoomPart>(most - border.begin());
                   });
}

/// Numbers the large connected pieces of the furniture.
void number_furniture(const geometry::Surface& surface, RoomParts& parts)
{
    std::vector<std::pair<double, std::vector<std::uint32_t>>> large;
    for_each_piece(surface, parts.of_face,
                   [&](RoomPart part, const std::vector<std::uint32_t>& piece, double area, const Border&)
                   {
                       if (part == RoomPart::furniture && area >= least_furniture_m2)
                           large.emplace_back(area, piece);
                   });
    std::ranges::stable_sort(large, std::greater<>(), &decltype(large)::value_type::first);
    large.resize(std::min(large.size(), most_furniture));
    parts.furniture_count = large.size();
    parts.furniture_of_face.assign(parts.of_face.size(), 0);
    for (std::size_t i = 0; i < large.size(); ++i)
        for (const std::uint32_t f : large[i].second)
            parts.furniture_of_face[f] = static_cast<std::uint16_t>(i + 1);
}

/// Mean heights of roughly level surfaces in squares of cell_m; several per square if storeys lie above each other.
class HeightGrid
{
  public:
    static constexpr double cell_m = 0.1;

    void add(Vec3d point, double weight)
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
    std::optional<double> near(Vec3d point, int cells) const
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

using numerics::cosine_deg;

// Floors. The lowest level surface of at least this share of the largest one is the floor.
constexpr double level_deg = 15;
constexpr double level_height_m = 0.12;
constexpr double least_floor_m2 = 0.3;
constexpr double least_floor_share = 0.15;
// Other levels in one piece: a storey, or a raised part of the floor that is larger than any bed.
constexpr double storey_height_m = 1.8;
constexpr double least_storey_m2 = 2;
constexpr double step_height_m = 0.6;
constexpr double least_step_m2 = 5;
// Ceilings: nobody stands under lower ones. They may slant as roofs do.
constexpr double headroom_m = 1.8;
constexpr double slant_deg = 65;
constexpr double least_ceiling_m2 = 0.3;
constexpr double beam_m = 0.2;
constexpr int beam_cells = 4;
// Walls.
constexpr double upright_deg = 20;
constexpr double least_wall_m2 = 0.25;
constexpr double least_wall_height_m = 0.5;
constexpr double least_low_wall_height_m = 0.4;
constexpr double eye_height_m = 1.5;
constexpr double counter_height_m = 1;
constexpr double least_wall_width_m = 0.8;
constexpr double below_ceiling_m = 0.3;
constexpr double most_overtopped = 0.5;
constexpr double most_backed = 0.2;
constexpr double beside_wall_m = 0.3;
constexpr double same_plane_deg = 12;
/// Rugs, pictures, skirting and doors are as close to the floor or a wall.
constexpr double thickness_m = 0.06;
/// A face belongs to a plane that it is close to if it faces roughly the same way: rounded edges do, tables at a wall do not.
constexpr double roughly_cosine = 0.5;

class RoomFinder
{
  public:
    RoomFinder(const SmoothSurface& surface, const std::vector<PlaneSegment>& segments) : surface_(surface), segments_(segments)
    {
        parts_.of_face.assign(surface.mesh.triangles.size(), RoomPart::furniture);
    }

    RoomParts find(const Progress& progress)
    {
        find_floors();
        find_ceilings();
        progress.check_canceled();
        find_walls();
        progress.check_canceled();
        take_what_is_close(progress);
        absorb_small_islands(surface_, parts_.of_face);
        number_furniture(surface_, parts_);
        return std::move(parts_);
    }

  private:
    void mark(const PlaneSegment& segment, RoomPart part)
    {
        for (const std::uint32_t f : segment.faces)
            parts_.of_face[f] = part;
    }

    void find_floors()
    {
        std::vector<const PlaneSegment*> level;
        for (const PlaneSegment& segment : segments_)
            if (segment.normal.z > cosine_deg(level_deg))
                level.push_back(&segment);
        std::ranges::stable_sort(level, {}, [](const PlaneSegment* s) { return s->middle.z; });
        const auto area_above = [&](std::size_t i)
        {
            double area = 0;
            for (std::size_t j = i; j < level.size() && level[j]->middle.z <= level[i]->middle.z + level_height_m; ++j)
                area += level[j]->area;
            return area;
        };
        double largest = 0;
        for (std::size_t i = 0; i < level.size(); ++i)
            largest = std::max(largest, area_above(i));
        for (std::size_t i = 0; i < level.size(); ++i)
            if (area_above(i) >= std::max(least_floor_m2, least_floor_share * largest))
            {
                add_floor(level, level[i]->middle.z);
                break;
            }
        if (parts_.floor_heights_m.empty())
            return;
        for (const PlaneSegment* segment : level)
        {
            const double height = segment->middle.z - parts_.floor_heights_m.back();
            if ((height > storey_height_m && segment->area >= least_storey_m2) ||
                (height > level_height_m && height < step_height_m && segment->area >= least_step_m2))
                add_floor(level, segment->middle.z);
        }
    }

    void add_floor(const std::vector<const PlaneSegment*>& level, double lowest)
    {
        HeightGrid grid;
        double sum = 0;
        double area = 0;
        for (const PlaneSegment* segment : level)
            if (segment->middle.z >= lowest && segment->middle.z <= lowest + level_height_m)
            {
                mark(*segment, RoomPart::floor);
                add_heights(*segment, grid);
                sum += segment->middle.z * segment->area;
                area += segment->area;
            }
        floors_.push_back(std::move(grid));
        parts_.floor_heights_m.push_back(sum / area);
    }

    void add_heights(const PlaneSegment& segment, HeightGrid& grid) const
    {
        for (const std::uint32_t f : segment.faces)
            grid.add(surface_.middles[f], surface_.areas[f]);
    }

    /// Height of the highest floor that is clearly below, or of the lowest floor.
    std::optional<double> floor_below(double height) const
    {
        std::optional<double> result;
        for (const double floor : parts_.floor_heights_m)
            if (!result || floor < height)
                result = floor;
        return result;
    }

    void find_ceilings()
    {
        std::vector<std::pair<double, const PlaneSegment*>> below;
        for (const PlaneSegment& segment : segments_)
            if (segment.normal.z < -cosine_deg(slant_deg))
                below.emplace_back(highest_face(segment), &segment);
        std::ranges::stable_sort(below, std::greater<>(), &std::pair<double, const PlaneSegment*>::first);
        for (const auto& [highest, segment] : below)
            if (const auto floor = floor_below(highest - headroom_m);
                segment->area >= least_ceiling_m2 && floor && highest > *floor + headroom_m && !is_under_ceiling(*segment))
                add_ceiling(*segment);
        // Pieces of the ceiling that beams and shelves cut off, then the undersides of the beams.
        std::vector<const PlaneSegment*> large;
        for (const auto& [highest, segment] : below)
            if (is_part(*segment, RoomPart::ceiling))
                large.push_back(segment);
        const auto in_plane_of = [&](const PlaneSegment& piece)
        {
            return std::ranges::any_of(large,
                                       [&](const PlaneSegment* ceiling)
                                       {
                                           return dot(ceiling->normal, piece.normal) > cosine_deg(same_plane_deg) &&
                                                  std::abs(ceiling->distance(piece.middle)) < thickness_m;
                                       });
        };
        for (const auto& [highest, segment] : below)
            if (!is_part(*segment, RoomPart::ceiling) && in_plane_of(*segment))
                add_ceiling(*segment);
        const HeightGrid whole = ceiling_;
        for (const auto& [highest, segment] : below)
            if (const auto height = whole.near(segment->middle, beam_cells);
                !is_part(*segment, RoomPart::ceiling) && height && std::abs(segment->middle.z - *height) < beam_m)
                add_ceiling(*segment);
    }

    bool is_part(const PlaneSegment& segment, RoomPart part) const { return parts_.of_face[segment.faces.front()] == part; }

    double highest_face(const PlaneSegment& segment) const
    {
        double highest = segment.middle.z;
        for (const std::uint32_t f : segment.faces)
            highest = std::max(highest, surface_.middles[f].z);
        return highest;
    }

    /// Most of it has a ceiling above that belongs to the same storey: it is the underside of a shelf.
    bool is_under_ceiling(const PlaneSegment& segment) const
    {
        double under = 0;
        for (const std::uint32_t f : segment.faces)
        {
            const Vec3d at = surface_.middles[f];
            const auto height = ceiling_.near(at, 1);
            under += height && *height > at.z + beam_m && *height < at.z + headroom_m ? surface_.areas[f] : 0;
        }
        return under > segment.area / 2;
    }

    void add_ceiling(const PlaneSegment& segment)
    {
        mark(segment, RoomPart::ceiling);
        add_heights(segment, ceiling_);
        auto& heights = parts_.ceiling_heights_m;
        if (heights.empty())
            heights = {segment.middle.z, segment.middle.z};
        heights = {std::min(heights[0], segment.middle.z), std::max(heights[1], segment.middle.z)};
    }

    void find_walls()
    {
        const double upright = std::sin(upright_deg * std::numbers::pi / 180);
        for (const PlaneSegment& segment : segments_)
            if (std::abs(segment.normal.z) < upright)
                upright_.push_back(wall_columns(surface_, segment));
        // Windows and pictures are part of the wall that they stand out of before they could be low walls themselves.
        for (const bool low : {false, true})
        {
            const std::size_t first = walls_.size();
            add_walls([&](const WallColumns& columns) { return low ? is_low_wall(columns) : is_wall(columns); });
            const std::size_t found = walls_.size();
            parts_.wall_planes += found - first;
            add_walls(
                [&](const WallColumns& columns)
                {
                    const auto begin = walls_.begin();
                    return std::any_of(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(found),
                                       [&](const WallColumns* wall) { return continues(*wall, columns); });
                });
        }
    }

    template <class Condition>
    void add_walls(const Condition& is_one)
    {
        for (const WallColumns& columns : upright_)
            if (!is_part(*columns.segment, RoomPart::walls) && is_one(columns))
            {
                walls_.push_back(&columns);
                mark(*columns.segment, RoomPart::walls);
            }
    }

    /// Under a ceiling a wall reaches it; where none was scanned, the wall may not have been up to its top either.
    bool is_wall(const WallColumns& wall) const
    {
        return is_large(wall, least_wall_height_m) && reaches_ceiling(wall).value_or(is_wide_and_high(wall, eye_height_m)) &&
               !is_overtopped(wall);
    }

    /// A wall that cupboards above it or the end of the scan cut off below eye height: unlike furniture, it has nothing behind.
    bool is_low_wall(const WallColumns& wall) const
    {
        return is_large(wall, least_low_wall_height_m) && is_wide_and_high(wall, counter_height_m) && !is_overtopped(wall) &&
               backed_share(surface_, wall, segments_) < most_backed;
    }

    static bool is_large(const WallColumns& wall, double least_height_m)
    {
        return wall.segment->area >= least_wall_m2 && wall.high - wall.low >= least_height_m;
    }

    bool is_wide_and_high(const WallColumns& wall, double above_floor_m) const
    {
        const auto floor = floor_below(wall.low + storey_height_m / 2);
        return wall.width() >= least_wall_width_m && (!floor || wall.high > *floor + above_floor_m);
    }

    bool is_overtopped(const WallColumns& wall) const { return overtopped_share(wall, upright_) >= most_overtopped; }

    /// Returns nothing where no ceiling is near most of the wall.
    std::optional<bool> reaches_ceiling(const WallColumns& wall) const
    {
        constexpr double least_share = 0.3;
        std::size_t columns = 0;
        std::size_t reaching = 0;
        std::size_t under = 0;
        for (const WallColumns::Column& column : wall.columns)
        {
            if (!(column.area > 0))
                continue;
            ++columns;
            if (const auto ceiling = ceiling_.near({column.middle.x, column.middle.y, column.top}, beam_cells);
                ceiling && *ceiling > wall.low)
            {
                ++under;
                reaching += column.top > *ceiling - below_ceiling_m ? 1 : 0;
            }
        }
        if (2 * under < columns)
            return std::nullopt;
        return static_cast<double>(reaching) >= least_share * static_cast<double>(columns);
    }

    /// A piece of a wall's plane beside or within it, which furniture or holes have cut off.
    bool continues(const WallColumns& wall, const WallColumns& piece) const
    {
        const Vec3d middle = piece.segment->middle;
        if (dot(wall.segment->normal, piece.segment->normal) < cosine_deg(same_plane_deg) ||
            std::abs(wall.segment->distance(middle)) > thickness_m)
            return false;
        return is_beside(wall, middle, beside_wall_m + piece.width() / 2);
    }

    static bool is_beside(const WallColumns& wall, Vec3d point, double within_m = beside_wall_m)
    {
        const double u = dot(wall.along, point) - wall.first;
        return u > -within_m && u < wall.width() + within_m;
    }

    void take_what_is_close(const Progress& progress)
    {
        constexpr std::size_t faces_per_piece = 1U << 14;
        parallel_items(parts_.of_face.size(), faces_per_piece, progress,
                       [&](std::size_t f)
                       {
                           if (parts_.of_face[f] == RoomPart::furniture)
                               parts_.of_face[f] = part_close_to(surface_.middles[f], surface_.smooth_normals[f]);
                       });
    }

    RoomPart part_close_to(Vec3d point, Vec3d normal) const
    {
        constexpr int cells = 2;
        const auto is_at = [&](const HeightGrid& grid)
        {
            const auto height = grid.near(point, cells);
            return height && std::abs(point.z - *height) < thickness_m;
        };
        // Takes the part with the most similar direction, which divides the rounded edges of a scan in the middle.
        double best = roughly_cosine;
        RoomPart part = RoomPart::furniture;
        const auto offer = [&](RoomPart offered, double cosine)
        {
            if (cosine > best)
            {
                best = cosine;
                part = offered;
            }
        };
        for (const WallColumns* wall : walls_)
            if (std::abs(wall->segment->distance(point)) < thickness_m && point.z < wall->high + beside_wall_m &&
                is_beside(*wall, point))
                offer(RoomPart::walls, dot(wall->segment->normal, normal));
        if (normal.z > best && std::ranges::any_of(floors_, is_at))
            offer(RoomPart::floor, normal.z);
        if (-normal.z > best && is_at(ceiling_))
            offer(RoomPart::ceiling, -normal.z);
        if (part != RoomPart::furniture)
            return part;
        if (const auto height = ceiling_.near(point, beam_cells); height && std::abs(point.z - *height) < beam_m)
            return RoomPart::ceiling;
        return RoomPart::furniture;
    }

    const SmoothSurface& surface_;
    const std::vector<PlaneSegment>& segments_;
    RoomParts parts_;
    std::vector<HeightGrid> floors_;
    HeightGrid ceiling_;
    std::vector<WallColumns> upright_;
    std::vector<const WallColumns*> walls_;
};

}  // namespace

RoomParts find_room_parts(const Mesh& upright, const Progress& progress)
{
    const Mesh mesh = texturing::welded(upright);
    const SmoothSurface surface(mesh, progress);
    const std::vector<PlaneSegment> segments = plane_segments(surface, progress);
    return RoomFinder(surface, segments).find(progress);
}
