#include <fresco/recordings/panorama.h>

#include <fresco/error.h>
#include <fresco/numerics/bilinear.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <vector>

namespace fresco::recordings
{
namespace
{

using std::numbers::pi;

constexpr double half_view = 48 * pi / 180;

/// Calls visit(x, y, direction, place) for the pixels of a view: the direction in its axes, of depth 1, and the place in a
/// panorama of `width`, in pixels.
template <class Visit>
void for_each_pixel(const PanoramaFace& face, int width, const Visit& visit)
{
    const auto& k = face.camera;
    for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x)
        {
            const Vec3d direction{(x + 0.5 - k.cx) / k.fx, (y + 0.5 - k.cy) / k.fy, 1};
            const Vec3d d = face.panorama_from_face * direction;
            visit(x, y, direction,
                  Vec2d{(std::atan2(d.x, d.z) / (2 * pi) + 0.5) * width,
                        (0.5 + std::atan2(d.y, std::hypot(d.x, d.z)) / pi) * (width / 2)});
        }
}

/// The pixel at (x, y), no more than a picture away, on the sphere: over a pole it goes down on the other side.
template <class T>
const T* around(const Raster<T>& panorama, int x, int y)
{
    if (y < 0 || y >= panorama.height)
    {
        y = y < 0 ? -1 - y : 2 * panorama.height - 1 - y;
        x += panorama.width / 2;
    }
    x += x < 0 ? panorama.width : 0;
    x -= x >= panorama.width ? panorama.width : 0;
    return &panorama.at(x, y);
}

}  // namespace

std::array<PanoramaFace, panorama_faces_count> panorama_faces(int width)
{
    const double focal = width / (2 * pi);
    const int size = std::max(1, static_cast<int>(std::lround(2 * focal * std::tan(half_view))));
    PanoramaFace face;
    face.camera = {size, size, size / 2.0 / std::tan(half_view), size / 2.0 / std::tan(half_view), size / 2.0, size / 2.0};
    struct Axes
    {
        Vec3d right, forward;
    };
    constexpr std::array<Axes, panorama_faces_count> sides{{{{1, 0, 0}, {0, 0, 1}},
                                                            {{0, 0, -1}, {1, 0, 0}},
                                                            {{-1, 0, 0}, {0, 0, -1}},
                                                            {{0, 0, 1}, {-1, 0, 0}},
                                                            {{1, 0, 0}, {0, -1, 0}},
                                                            {{1, 0, 0}, {0, 1, 0}}}};
    std::array<PanoramaFace, panorama_faces_count> faces;
    for (std::size_t i = 0; i < faces.size(); ++i)
    {
        const auto& [right, forward] = sides[i];
        const Vec3d down = cross(forward, right);
        face.panorama_from_face.m = {right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z};
        faces[i] = face;
    }
    return faces;
}

void check_panorama(const std::filesystem::path& file, const ImageHeader& header)
{
    if (header.width != 2 * header.height)
        throw Error(fmt::format("{}: {}x{} pixels; a 360° picture (equirectangular) is twice as wide as high: export the whole "
                                "sphere, uncropped",
                                file.string(), header.width, header.height));
}

void widen_at_poles(Raster8& panorama)
{
    const auto width = static_cast<std::size_t>(panorama.width), channels = static_cast<std::size_t>(panorama.channels);
    std::vector<double> sums(width + 1);  // Sums of the columns before.
    for (int y = 0; y < panorama.height; ++y)
    {
        const double latitude = pi * (0.5 - (y + 0.5) / panorama.height);
        const double columns = std::min<double>(panorama.width, std::abs(std::tan(latitude)));
        if (columns <= 1)
            continue;
        std::uint8_t* const row = &panorama.at(0, y);
        for (std::size_t c = 0; c < channels; ++c)
        {
            for (std::size_t x = 0; x < width; ++x)
                sums[x + 1] = sums[x] + row[x * channels + c];
            const auto sum_before = [&](double column)
            {
                const double turns = std::floor(column / panorama.width);
                const auto at = numerics::between<double>(column - turns * panorama.width, panorama.width + 1);
                return turns * sums[width] + sums[static_cast<std::size_t>(at.first)] * (1 - at.share) +
                       sums[static_cast<std::size_t>(at.second)] * at.share;
            };
            for (std::size_t x = 0; x < width; ++x)
            {
                const double middle = static_cast<double>(x) + 0.5;
                const double sum = sum_before(middle + columns / 2) - sum_before(middle - columns / 2);
                row[x * channels + c] = static_cast<std::uint8_t>(sum / columns + 0.5);
            }
        }
    }
}

Raster8 face_of(const Raster8& panorama, const PanoramaFace& face)
{
    Raster8 view(face.camera.width, face.camera.height, panorama.channels);
    for_each_pixel(face, panorama.width,
                   [&](int x, int y, Vec3d, Vec2d at)
                   {
                       const auto column = numerics::between(at.x - 0.5), row = numerics::between(at.y - 0.5);
                       for (int c = 0; c < panorama.channels; ++c)
                           view.at(x, y, c) = static_cast<std::uint8_t>(
                               numerics::bilinear(column, row, [&](int u, int v) { return around(panorama, u, v)[c]; }) + 0.5);
                   });
    return view;
}

Raster16 depth_face_of(const Raster16& panorama, const PanoramaFace& face)
{
    Raster16 view(face.camera.width, face.camera.height);
    for_each_pixel(face, panorama.width,
                   [&](int x, int y, Vec3d direction, Vec2d at)
                   {
                       const auto steps = *around(panorama, static_cast<int>(at.x), static_cast<int>(at.y));
                       if (steps != std::numeric_limits<std::uint16_t>::max())
                           view.at(x, y) = static_cast<std::uint16_t>(steps / length(direction) + 0.5);
                   });
    return view;
}

}  // namespace fresco::recordings
