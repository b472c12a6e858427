#include "room_picture.h"

#include <fresco/camera.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>
#include <fresco/rendering/raster_finder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

using namespace fresco;

namespace
{

constexpr int width = 720;
constexpr int height = 360;

/// A camera far above the room that looks down at it along a horizontal direction. Its picture shows all but the 1% of the
/// vertices that lie farthest out to each side, such as scraps of a scan seen through a door.
Camera camera_above(const Mesh& room, double azimuth_deg)
{
    constexpr double elevation = 50 * std::numbers::pi / 180;
    constexpr double distance = 5;  // In diagonals of the room.
    constexpr double margin = 0.9;
    const double azimuth = azimuth_deg * std::numbers::pi / 180;
    const Vec3d right{-std::sin(azimuth), std::cos(azimuth), 0};
    const Vec3d forward{-std::cos(azimuth) * std::cos(elevation), -std::sin(azimuth) * std::cos(elevation), -std::sin(elevation)};
    const Vec3d down = cross(forward, right);
    numerics::Bounds<float> box;
    for (const Vec3f& position : room.positions)
        box.add(position);
    const Vec3d low = vec_cast<double>(box.low);
    const Vec3d high = vec_cast<double>(box.high);
    Camera camera{{width, height, 1, 1, 0, 0}, {}};
    camera.world_from_camera = {
        {{right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z}},
        (low + high) * 0.5 - forward * (distance * length(high - low)),
    };
    std::array<std::vector<double>, 2> seen;
    for (const Vec3f& position : room.positions)
    {
        const Vec3d at = camera.project(vec_cast<double>(position));
        seen[0].push_back(at.x);
        seen[1].push_back(at.y);
    }
    std::array<double, 2> middle{};
    std::array<double, 2> size{};
    for (const std::size_t axis : {0U, 1U})
    {
        std::ranges::sort(seen[axis]);
        const std::size_t scraps = seen[axis].size() / 100;
        const double first = seen[axis][scraps];
        const double last = seen[axis][seen[axis].size() - 1 - scraps];
        middle[axis] = (first + last) / 2;
        size[axis] = std::max(last - first, 1e-3);
    }
    const double focal = margin * std::min(width / size[0], height / size[1]);
    camera.intrinsics = {width, height, focal, focal, width / 2.0 - focal * middle[0], height / 2.0 - focal * middle[1]};
    return camera;
}

/// Writes a number in black on white around a pixel.
void write_number(Raster8& picture, int x, int y, std::size_t number)
{
    // Rows of 3 pixels, from the top, as octal digits.
    constexpr std::array<int, 10> digits{075557, 026227, 071747, 071717, 055711, 074717, 074757, 071122, 075757, 075717};
    constexpr int scale = 3;
    const std::string text = std::to_string(number);
    const int columns = 4 * static_cast<int>(text.size()) + 1;
    for (int j = 0; j < 7 * scale; ++j)
        for (int i = 0; i < columns * scale; ++i)
        {
            const int column = i / scale - 1;
            const int row = j / scale - 1;
            bool is_ink = false;
            if (column >= 0 && column % 4 < 3 && row >= 0 && row < 5)
                is_ink = (digits[static_cast<std::size_t>(text[static_cast<std::size_t>(column / 4)] - '0')] >>
                              (3 * (4 - row) + 2 - column % 4) &
                          1) != 0;
            const int to_x = x + i - columns * scale / 2;
            const int to_y = y + j - 7 * scale / 2;
            if (to_x >= 0 && to_x < picture.width && to_y >= 0 && to_y < picture.height)
                std::fill_n(&picture.at(to_x, to_y), 3, is_ink ? std::uint8_t{0} : std::uint8_t{255});
        }
}

/// Writes each number onto the pixel of its piece that lies nearest to the middle of what is seen of it.
void write_numbers(Raster8& picture, const std::vector<std::vector<std::array<int, 2>>>& pixels_of)
{
    for (std::size_t number = pixels_of.size(); number-- > 1;)
    {
        const auto& pixels = pixels_of[number];
        if (pixels.empty())
            continue;
        std::array<std::int64_t, 2> sum{};
        for (const auto& [x, y] : pixels)
            sum = {sum[0] + x, sum[1] + y};
        const auto count = static_cast<std::int64_t>(pixels.size());
        const auto off = [&](const std::array<int, 2>& pixel)
        {
            const std::int64_t dx = pixel[0] - sum[0] / count;
            const std::int64_t dy = pixel[1] - sum[1] / count;
            return dx * dx + dy * dy;
        };
        const auto& [x, y] = *std::ranges::min_element(pixels, {}, off);
        write_number(picture, x, y, number);
    }
}

}  // namespace

Raster8 room_picture(const Mesh& upright, const RoomParts& parts, const Progress& progress)
{
    constexpr std::array<double, 4> grays{200, 225, 225, 130};  // By RoomPart.
    constexpr double golden = 0.618034;                         // Steps of this share of a turn give all numbers other hues.
    const Vec3d light = normalized(Vec3d{0.3, 0.5, 0.8});
    // Furniture is seen from behind, too: a camera that passed it may have recorded one side.
    Mesh shown = upright;
    std::vector<std::uint32_t> face_of(upright.triangles.size());
    std::iota(face_of.begin(), face_of.end(), 0U);
    for (std::uint32_t face = 0; face < upright.triangles.size(); ++face)
        if (parts.furniture_of_face[face] > 0)
        {
            const auto& [a, b, c] = upright.triangles[face];
            shown.triangles.push_back({a, c, b});
            face_of.push_back(face);
        }
    rendering::RasterFinder finder(shown, true);
    Raster8 picture(width, 2 * height, 3, 255);
    std::vector<std::vector<std::array<int, 2>>> pixels_of(parts.furniture_count + 1);
    for (const int side : {0, 1})
    {
        const Camera camera = camera_above(upright, side == 0 ? -60 : 120);
        std::vector<FaceMap> faces(1, FaceMap(width, height));
        finder.find(std::span(&camera, 1), progress, faces);
        for (auto& pixels : pixels_of)
            pixels.clear();
        Raster8 view(width, height, 3, 255);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
            {
                const std::uint32_t seen = faces.front().at(x, y);
                if (seen == no_face)
                    continue;
                const std::uint32_t face = face_of[seen];
                const std::size_t number = parts.furniture_of_face[face];
                const double gray = grays[static_cast<std::size_t>(parts.of_face[face])];
                const double shade = 0.75 + 0.25 * dot(normalized(geometry::area_vector(shown, seen)), light);
                for (int c = 0; c < 3; ++c)
                {
                    const double turn = static_cast<double>(number) * golden + c / 3.0;
                    const double value = number == 0 ? gray : 150 + 100 * std::cos(2 * std::numbers::pi * turn);
                    view.at(x, y, c) = static_cast<std::uint8_t>(std::lround(shade * value));
                }
                pixels_of[number].push_back({x, y});
            }
        write_numbers(view, pixels_of);
        std::ranges::copy(view.values, &picture.at(0, side * height));
    }
    return picture;
}
