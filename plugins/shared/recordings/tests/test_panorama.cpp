#include "catch.h"

#include <fresco/recordings/panorama.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

using fresco::Raster16;
using fresco::Vec2d;
using fresco::Vec3d;
using namespace fresco::recordings;
using fresco::testing::noise_picture;
using std::numbers::pi;

namespace
{

/// Yaw to the right, then pitch upward, degrees, of the views in order.
constexpr std::array<std::array<double, 2>, 6> turns{{{0, 0}, {90, 0}, {180, 0}, {-90, 0}, {0, 90}, {0, -90}}};

/// Position in the panorama of what a view sees at (x, y), by the obvious formulas.
Vec2d place_of(const PanoramaFace& face, std::size_t index, double x, double y, int width, int height)
{
    const double yaw = turns[index][0] * pi / 180, pitch = turns[index][1] * pi / 180;
    const Vec3d d{(x - face.camera.cx) / face.camera.fx, (y - face.camera.cy) / face.camera.fy, 1};
    const Vec3d p{d.x, std::cos(pitch) * d.y - std::sin(pitch) * d.z, std::sin(pitch) * d.y + std::cos(pitch) * d.z};
    const Vec3d q{std::cos(yaw) * p.x + std::sin(yaw) * p.z, p.y, -std::sin(yaw) * p.x + std::cos(yaw) * p.z};
    const double theta = std::atan2(q.x, q.z), phi = std::asin(-q.y / length(q));
    return {(theta / (2 * pi) + 0.5) * width, (0.5 - phi / pi) * height};
}

}  // namespace

TEST_CASE("views are what the obvious formulas sample, pixel by pixel", "[recordings]")
{
    const auto panorama = noise_picture(100, 50, 1);
    Raster16 depth(100, 50);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        depth.values[i] = i % 7 == 0 ? 0 : i % 11 == 0 ? 65535 : static_cast<std::uint16_t>(500 + 11 * i);
    const auto faces = panorama_faces(100);
    CHECK((faces[0].camera.width == 35 && faces[0].camera.height == 35));  // 100 * tan(48 degrees) / pi.
    // The sphere once more around each side, and over the poles on the other side.
    const auto at = [&](const auto& picture, int x, int y, int c)
    {
        const int folded = y < 0 ? -1 - y : y > 49 ? 99 - y : y;
        return picture.at((x + (folded == y ? 0 : 50) + 200) % 100, folded, c);
    };
    for (std::size_t i = 0; i < faces.size(); ++i)
    {
        const auto view = face_of(panorama, faces[i]);
        const auto depth_view = depth_face_of(depth, faces[i]);
        const auto& k = faces[i].camera;
        double worst = 0;
        int wrong_depths = 0;
        for (int y = 0; y < k.height; ++y)
            for (int x = 0; x < k.width; ++x)
            {
                const auto place = place_of(faces[i], i, x + 0.5, y + 0.5, 100, 50);
                const double u = place.x - 0.5, v = place.y - 0.5;
                const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
                const double right = u - column, down = v - row;
                for (int c = 0; c < 3; ++c)
                {
                    const double expected =
                        (1 - down) * ((1 - right) * at(panorama, column, row, c) + right * at(panorama, column + 1, row, c)) +
                        down * ((1 - right) * at(panorama, column, row + 1, c) + right * at(panorama, column + 1, row + 1, c));
                    worst = std::max(worst, std::abs(view.at(x, y, c) - expected));
                }
                const double steps = at(depth, static_cast<int>(std::floor(place.x)), static_cast<int>(std::floor(place.y)), 0);
                const double a = (x + 0.5 - k.cx) / k.fx, b = (y + 0.5 - k.cy) / k.fy;
                const double expected = steps == 65535 ? 0 : steps / std::sqrt(1 + a * a + b * b);
                // On the line between two pixels, either may be taken.
                const bool on_line =
                    std::abs(place.x - std::round(place.x)) < 1e-9 || std::abs(place.y - std::round(place.y)) < 1e-9;
                wrong_depths += !on_line && std::abs(depth_view.at(x, y) - expected) > 0.5 + 1e-9;
            }
        INFO("view " << i);
        CHECK(worst < 0.5 + 1e-6);
        CHECK(wrong_depths == 0);
    }
}

TEST_CASE("rows near the poles are averaged over what a pixel of the view covers", "[recordings]")
{
    const auto panorama = noise_picture(96, 48, 1);
    auto widened = panorama;
    widen_at_poles(widened);
    double worst = 0;
    for (int y = 0; y < 48; ++y)
    {
        const double columns = std::abs(std::tan(pi * (0.5 - (y + 0.5) / 48)));
        constexpr int samples = 2000;
        for (int x = 0; x < 96; x += 5)
            for (int c = 0; c < 3; ++c)
            {
                double expected = panorama.at(x, y, c);
                if (columns > 1)
                {
                    expected = 0;
                    for (int i = 0; i < samples; ++i)
                    {
                        const double place = x + 0.5 + columns * ((i + 0.5) / samples - 0.5);
                        expected += panorama.at((static_cast<int>(std::floor(place)) + 96) % 96, y, c) / double{samples};
                    }
                }
                worst = std::max(worst, std::abs(widened.at(x, y, c) - expected));
            }
    }
    CHECK(worst < 0.7);
    CHECK(std::equal(panorama.values.begin() + 12 * 96 * 3, panorama.values.begin() + 36 * 96 * 3,
                     widened.values.begin() + 12 * 96 * 3));
    CHECK(panorama.values != widened.values);
}

TEST_CASE("a picture of less than the whole sphere is refused", "[recordings]")
{
    CHECK_NOTHROW(check_panorama("a.jpg", {.width = 64, .height = 32}));
    CHECK_THROWS_WITH(check_panorama("a.jpg", {.width = 64, .height = 31}),
                      Catch::Contains("a.jpg: 64x31 pixels; a 360° picture (equirectangular) is twice as wide as high"));
}
