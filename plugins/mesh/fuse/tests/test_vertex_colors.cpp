#include "catch.h"
#include "vertex_colors.h"

#include <fresco/testing_scenes.h>

using namespace fresco;

namespace
{

Camera camera(int width, double x = 0)
{
    return testing::camera(width, width * 3 / 4, 0.6 * width, {x, 0, 0});
}

/// A wall at z = 1 that faces the camera, one vertex per decimeter from -0.5 to 0.5 by column, and one far
/// behind it.
Mesh wall()
{
    Mesh mesh = testing::rectangle({-0.5F, -0.5F, 1}, {0, 1, 0}, {1, 0, 0}, 10, 10);
    mesh.positions.push_back({0, 0, 2});
    return mesh;
}

std::vector<Rgb8> colors_of(const Mesh& mesh, std::span<const fuse::ColorView> views)
{
    const Progress progress;
    fuse::VertexColors colors(mesh, 0.05);
    colors.add(views, progress);
    return colors.colors();
}

}  // namespace

TEST_CASE("colors are those that the color camera sees, from where it is")
{
    const Mesh mesh = wall();
    // Seen 0.2 m from the right, in a picture of twice the size.
    const Raster8 columns = testing::picture(32, 24, [](int x, int, int c) { return c == 0 ? 5 * x : 0; });
    const fuse::ColorView view{camera(16), RasterF(16, 12, 1, 1), camera(32, 0.2), columns};
    const std::vector<Rgb8> result = colors_of(mesh, {&view, 1});
    for (std::size_t x = 2; x <= 8; ++x)
    {
        const double column = 19.2 * (0.1 * (static_cast<double>(x) - 5) - 0.2) + 16;
        CHECK(result[x * 11 + 5][0] == Approx(5 * (column - 0.5)).margin(0.51));
        CHECK(result[x * 11 + 5][1] == 0);
    }
}

TEST_CASE("what is hidden, seen along itself or by nobody takes the color of its neighbors, else gray")
{
    const Mesh mesh = wall();
    fuse::ColorView view{camera(160), RasterF(160, 120, 1, 1), camera(160), Raster8(160, 120, 3, 200)};
    const auto result = colors_of(mesh, {&view, 1});
    CHECK(result[60] == Rgb8{200, 200, 200});
    CHECK(result[121] == Rgb8{128, 128, 128});  // No face leads there.
    // Depth is 0 to the right of the middle: nothing is seen there.
    for (int y = 0; y < 120; ++y)
        for (int x = 80; x < 160; ++x)
            view.depth.at(x, y) = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 85; x < 160; ++x)
            view.picture.at(x, y, 0) = 10;
    CHECK(colors_of(mesh, {&view, 1})[9 * 11 + 5] == Rgb8{200, 200, 200});
    // Another view does see it, from twice as near, and counts four times as much.
    fuse::ColorView other = view;
    other.depth = RasterF(160, 120, 1, 0.5F);
    other.depth_camera.world_from_camera.translation.z = other.color_camera.world_from_camera.translation.z = 0.5;
    other.picture = Raster8(160, 120, 3, 100);
    const std::array<fuse::ColorView, 2> both{view, other};
    CHECK(colors_of(mesh, both)[4 * 11 + 5][1] == Approx((200 + 4 * 100) / 5.0).margin(1.5));
    // A surface that faces away is not seen.
    Mesh turned = mesh;
    for (Triangle& t : turned.triangles)
        std::swap(t[0], t[1]);
    CHECK(colors_of(turned, both)[60] == Rgb8{128, 128, 128});
}
