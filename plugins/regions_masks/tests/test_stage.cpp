#include "catch.h"
#include "raw_images.h"

#include <fresco/frames.h>
#include <fresco/regions/regions.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <functional>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

constexpr int width = 40;
constexpr int height = 30;

/// A wall of 4 x 3 squares of 1 m at z = 2, which faces the camera at the origin that sees all of it, and as much behind it.
Mesh wall()
{
    Mesh mesh;
    for (const float z : {2.0F, 3.0F})
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 4; ++x)
            {
                const auto first = static_cast<std::uint32_t>(mesh.positions.size());
                const Vec3f corner{static_cast<float>(x) - 2, static_cast<float>(y) - 1.5F, z};
                mesh.positions.insert(mesh.positions.end(),
                                      {corner, corner + Vec3f{0, 1, 0}, corner + Vec3f{1, 1, 0}, corner + Vec3f{1, 0, 0}});
                mesh.triangles.push_back({first, first + 1, first + 2});
                mesh.triangles.push_back({first, first + 2, first + 3});
            }
    return mesh;
}

Frames one_frame()
{
    Frames frames;
    frames.frames.push_back(testing::frame("frame-000000", testing::camera(width, height, 20)));
    return frames;
}

void draw(const fs::path& file, int w, int h, const std::function<bool(int, int)>& inside)
{
    Raster8 mask(w, h, 3);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
            for (int c = 0; c < 3; ++c)
                mask.at(x, y, c) = inside(x, y) ? 255 : 0;
    fs::create_directories(file.parent_path());
    write_file(file, testing::RawImages().encode_png(mask));
}

std::shared_ptr<Regions> masked(const fs::path& folder, testing::TestRun& run, const Regions* base = nullptr)
{
    testing::Inputs inputs{{"mesh", std::make_shared<Mesh>(wall())}, {"frames", std::make_shared<Frames>(one_frame())}};
    if (base != nullptr)
        inputs["regions"] = std::make_shared<Regions>(*base);
    testing::TemporaryFolder out;
    testing::run_stage(FRESCO_PLUGIN_FILE, "regions.masks", Value::Map{{"path", folder.string()}}, inputs, out.path(), run,
                       {{"images", std::make_shared<testing::RawImages>()}});
    return Regions::load({out.path() / "regions", out.path()});
}

}  // namespace

TEST_CASE("regions.masks: faces take the region that most of their pixels are in; hidden ones take none", "[regions.masks]")
{
    const testing::TemporaryFolder folder;
    // The left column of squares, and a bit of the next: less than half.
    draw(folder.path() / "window/frame-000000.png", width, height, [](int x, int) { return x < 12; });
    testing::TestRun run;
    const auto regions = masked(folder.path(), run);
    CHECK(regions->names == std::vector<std::string>{"window", "other"});
    for (std::size_t f = 0; f < regions->label_of_face.size(); ++f)
        CHECK(regions->names[regions->label_of_face[f]] == (f < 24 && f / 2 % 4 == 0 ? "window" : "other"));
    CHECK(run.reported.at("seen_share").as_double() == Approx(0.5));
    CHECK(run.files_read.size() == 1);

    Regions base = regions_from(wall(), {"floor", "walls"}, std::vector<std::uint32_t>(48, 1));
    base.label_of_face[47] = 1;
    base.names = {"walls", "floor"};
    const auto over = masked(folder.path(), run, &base);
    CHECK(over->names[over->label_of_face[0]] == "window");
    CHECK(over->names[over->label_of_face[2]] == base.names[base.label_of_face[2]]);
    CHECK(over->names[over->label_of_face[47]] == base.names[base.label_of_face[47]]);
}

TEST_CASE("regions.masks: masks of another size, or that mark nothing, are refused by name", "[regions.masks]")
{
    testing::TestRun run;
    const testing::TemporaryFolder small;
    draw(small.path() / "tv/frame-000000.png", width / 2, height / 2, [](int, int) { return true; });
    CHECK_THROWS_WITH(masked(small.path(), run),
                      Catch::Contains("tv/frame-000000.png: 20 x 15 pixels, but the color picture of the "
                                      "frame has 40 x 30: draw the mask at that size"));
    const testing::TemporaryFolder black;
    draw(black.path() / "tv/frame-000000.png", width, height, [](int, int) { return false; });
    CHECK_THROWS_WITH(masked(black.path(), run), Catch::Contains("tv: no mask marks any surface of the mesh"));
    Regions other;
    other.names = {"a"};
    other.label_of_face = {0};
    CHECK_THROWS_WITH(masked(black.path(), run, &other), Catch::Contains("the regions on port 'regions' are of another mesh"));
}
