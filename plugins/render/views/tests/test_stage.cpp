#include "catch.h"
#include "plugin_under_test.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <thread>

using namespace fresco;

namespace
{
/// A wall z = 2 over x, y in [-1,1] facing the origin; u runs with x, v against y.
TexturedMesh wall(Raster8 picture)
{
    TexturedMesh textured;
    textured.mesh = testing::wall(1);
    textured.image = Image(std::move(picture));
    return textured;
}

}  // namespace

TEST_CASE("one ray per pixel shows the bilinear value at the pixel center, the right way up")
{
    const TexturedMesh textured = wall(testing::picture(4, 4, [](int x, int y, int c) { return 60 * (c == 0 ? x : y); }));
    const rendering::ViewRenderer renderer(textured, {.samples_per_side = 1, .filter = rendering::TextureFilter::trilinear});
    const Raster8 image = renderer.render(testing::camera(40, 40, 40), Progress{});  // the wall fills it exactly
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x)
        {
            const double tx = std::clamp((x + 0.5) / 10 - 0.5, 0.0, 3.0);
            const double ty = std::clamp((y + 0.5) / 10 - 0.5, 0.0, 3.0);
            CHECK(std::abs(image.at(x, y, 0) - 60 * tx) <= 0.51);
            CHECK(std::abs(image.at(x, y, 1) - 60 * ty) <= 0.51);
            CHECK(image.at(x, y, 3) == 255);
        }
}

TEST_CASE("alpha is the share of a pixel that shows the surface")
{
    TexturedMesh textured = wall(Raster8(4, 4, 3, 90));
    const rendering::ViewRenderer renderer(textured, {.samples_per_side = 2, .filter = rendering::TextureFilter::trilinear});
    // 41 pixels across, the wall covers 40: half a pixel is free on each side.
    const Raster8 image = renderer.render(testing::camera(41, 41, 40), Progress{});
    CHECK(image.at(20, 20, 3) == 255);
    CHECK(image.at(0, 20, 3) == 128);
    CHECK(image.at(0, 0, 3) == 64);
    CHECK(image.at(0, 20, 0) == 90);  // straight alpha
    for (const Camera& behind :
         {testing::camera(41, 41, 40, {0, 0, 4}, std::numbers::pi), testing::camera(41, 41, 40, {0, 0, 5})})
        CHECK(renderer.render(behind, Progress{}) == Raster8(41, 41, 4));
}

TEST_CASE("pictures of a film come in order, one at a time, up to the first failure")
{
    TexturedMesh textured = wall(Raster8(4, 4, 3, 90));
    const rendering::ViewRenderer renderer(textured, {.samples_per_side = 1, .filter = rendering::TextureFilter::trilinear});
    std::vector<Camera> cameras;
    for (int i = 0; i < 40; ++i)
        cameras.push_back(testing::camera(i + 1, 8, 8));
    std::vector<int> all(40);
    std::iota(all.begin(), all.end(), 1);
    for (const int threads : {1, 4})
    {
        testing::TestRun run(threads);
        for (const int last : {1, 7, 40, 41})
        {
            std::atomic<int> at_once{0};
            std::vector<int> widths;
            const auto take = [&](const Raster8& picture)
            {
                CHECK(++at_once == 1);
                widths.push_back(picture.width);
                std::this_thread::sleep_for(std::chrono::microseconds(picture.width % 5 * 300));
                --at_once;
                if (picture.width == last)
                    throw Error("the disk is full");
            };
            if (last <= 40)
                CHECK_THROWS_WITH(renderer.render_in_order(cameras, run, take), "the disk is full");
            else
                CHECK_NOTHROW(renderer.render_in_order(cameras, run, take));
            CHECK(std::ranges::equal(widths, std::span(all).first(static_cast<std::size_t>(std::min(last, 40)))));
        }
        run.cancel_after(5);
        CHECK_THROWS_AS(renderer.render_in_order(cameras, run, [](const Raster8&) {}), Canceled);
    }
}

TEST_CASE("on a slanted wall, anisotropic lookups keep what runs along with the view, trilinear ones blur it")
{
    const TexturedMesh textured = wall(testing::picture(512, 512, [](int, int y, int) { return y / 16 % 2 == 0 ? 255 : 0; }));
    // From beside the wall, so that a pixel is many columns wide and few rows high.
    const Camera camera = testing::camera(60, 60, 60, {-1.6, 0, 1.6}, 1.35);
    const auto picture = [&](int samples, rendering::TextureFilter filter)
    { return rendering::ViewRenderer(textured, {.samples_per_side = samples, .filter = filter}).render(camera, Progress{}); };
    const Raster8 wanted = picture(8, rendering::TextureFilter::bilinear);
    const auto apart = [&](rendering::TextureFilter filter)
    {
        const Raster8 found = picture(1, filter);
        double sum = 0;
        for (std::size_t i = 0; i < found.values.size(); i += 4)
            if (found.values[i + 3] == 255 && wanted.values[i + 3] == 255)
                sum += std::abs(found.values[i] - wanted.values[i]);
        return sum;
    };
    CHECK(apart(rendering::TextureFilter::trilinear) > 1000);
    CHECK(apart(rendering::TextureFilter::anisotropic) < 0.5 * apart(rendering::TextureFilter::trilinear));
}

TEST_CASE("a pixel on one face, which is looked up once, is as sharp as the mean of its samples")
{
    const TexturedMesh noise = wall(testing::noise_picture(256, 256, 1));
    const auto contrast = [&](const rendering::Lights& lights)
    {
        const rendering::ViewRenderer renderer(noise, {.filter = rendering::TextureFilter::trilinear, .lights = lights});
        const Raster8 picture = renderer.render(testing::camera(120, 120, 120), Progress{});
        double sum = 0;
        for (std::size_t i = 0; i < picture.values.size(); i += 4)
            sum += (picture.values[i] - 127.5) * (picture.values[i] - 127.5);
        return std::sqrt(sum);
    };
    // With a lamp, though one without light, every sample is looked up.
    CHECK(contrast({}) == Approx(contrast({.diffuse = 1e-9})).epsilon(0.1));
}

TEST_CASE("lamps of the published viewers, on walls that face them, stand askew and face away")
{
    TexturedMesh textured = wall(Raster8(4, 4, 3, 100));
    // The wall's normal is -z, and becomes `normal`; the camera turns with it.
    const auto shown = [&](const char* shading, const Vec3d& normal)
    {
        const Mat3 turn = testing::looking_at({}, -normal, {1, 2, 3}).rotation;
        TexturedMesh turned = textured;
        for (Vec3f& position : turned.mesh.positions)
            position = vec_cast<float>(turn * vec_cast<double>(position));
        Camera camera = testing::camera(8, 8, 8);
        camera.world_from_camera.rotation = turn;
        const rendering::ViewRenderer renderer(
            turned,
            {.samples_per_side = 2, .filter = rendering::TextureFilter::trilinear, .lights = rendering::lights_of(shading)});
        return static_cast<int>(renderer.render(camera, Progress{}).at(4, 4, 0));
    };
    CHECK(shown("none", {0, 0, 1}) == 100);
    CHECK(shown("scannet", {0, 0, -1}) == 40);
    CHECK(shown("scannet", {0, 0, 1}) == 98);   // 0.4 + 1/√3
    CHECK(shown("scannet", {1, 0, 1}) == 122);  // 0.4 + 2/√6
    CHECK(shown("matterport3d", {0, 0, -1}) == 90);
    CHECK(shown("matterport3d", {1, 0, 1}) == 150);
    CHECK(shown("matterport3d", {1, 0, 0}) == 132);  // 0.9 + 0.6/√2
    CHECK(shown("matterport3d", {0, 1, 0}) == 90);
    textured = wall(Raster8(4, 4, 3, 200));
    CHECK(shown("matterport3d", {1, 0, 1}) == 255);
}

namespace
{
std::shared_ptr<Frames> three_frames()
{
    auto frames = std::make_shared<Frames>();
    for (const char* name : {"frame-0", "frame-1", "frame-2"})
    {
        frames->frames.push_back(testing::frame(name, testing::camera(32, 24, 24)));
        frames->frames.back().depth = testing::camera(8, 6, 6);
    }
    frames->frames[2].color.world_from_camera.translation = {0, 0, 5};
    return frames;
}

/// The names of the pictures in folder/views.
std::vector<std::string> render_to(const std::filesystem::path& folder, const Value& options, testing::TestRun& run,
                                   std::shared_ptr<Frames> frames, const TexturedMesh& mesh = wall(Raster8(8, 8, 3)))
{
    testing::Inputs inputs{{"mesh", std::make_shared<TexturedMesh>(mesh)}};
    if (frames)
        inputs["frames"] = frames;
    testing::run_stage(FRESCO_PLUGIN_FILE, "render.views", options, inputs, folder, run,
                       {{"image_io", std::make_shared<stored_png::Codec>()}});
    return Files::load({folder / "views", folder})->names;
}
}  // namespace

TEST_CASE_METHOD(testing::StageTest,
                 "from above, the whole room is in the picture, its longer side across, not mirrored, and without its ceiling")
{
    // A floor of 4 m x 2 m, turned by 30 degrees about z, which is up: red at one end, the rest half green, half black. The
    // ceiling, seen from its back, is blue.
    TexturedMesh room;
    const auto add = [&](Vec3f corner, Vec3f x, Vec3f y, Vec2f uv)
    {
        Mesh part = testing::rectangle(corner, x, y);
        testing::set_texcoords(part, [&](Vec3f) { return uv; });
        testing::append(room.mesh, part);
    };
    add({0, 0, 1}, {1, 0, 0}, {0, 2, 0}, {0.25F, 0.75F});
    add({1, 0, 1}, {3, 0, 0}, {0, 1, 0}, {0.75F, 0.75F});
    add({1, 1, 1}, {3, 0, 0}, {0, 1, 0}, {0.75F, 0.25F});
    add({0, 0, 3}, {0, 2, 0}, {4, 0, 0}, {0.25F, 0.25F});
    for (Vec3f& p : room.mesh.positions)
        p = {7 + 0.866F * p.x - 0.5F * p.y, 0.5F * p.x + 0.866F * p.y, p.z};
    room.image = Image(Raster8(2, 2, 3));
    room.image.pixels.at(0, 0, 0) = room.image.pixels.at(1, 0, 1) = room.image.pixels.at(0, 1, 2) = 255;

    // The camera looks along y, upright: z is up.
    auto frames = std::make_shared<Frames>();
    frames->frames.push_back(testing::frame("frame-0", testing::camera(32, 24, 24)));
    frames->frames[0].color.world_from_camera.rotation =
        frames->frames[0].depth.world_from_camera.rotation = {{1, 0, 0, 0, 0, 1, 0, -1, 0}};
    const Value options = Value::Map{{"height_px", 100}, {"above", true}, {"filter", "bilinear"}, {"samples", 1}};
    REQUIRE(render_to(folder.path(), options, run, frames, room) == std::vector<std::string>{"views/above_room.png"});
    const Raster8 picture = stored_png::Codec().read_rgb(folder.path() / "views/views/above_room.png");
    CHECK(picture.width == Approx(200).margin(6));
    CHECK(picture.height == 100);
    std::array<int, 3> pixels{};
    std::array<Vec2d, 3> middle{};
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                if (picture.at(x, y, static_cast<int>(c)) > 200)
                {
                    ++pixels[c];
                    middle[c] = middle[c] + Vec2d{x - picture.width / 2.0, y - picture.height / 2.0};
                }
    const Vec2d red = middle[0] * (1.0 / pixels[0]);
    const Vec2d green = middle[1] * (1.0 / pixels[1]);
    // The ceiling, with a margin of 4 %, fills the picture from 1.04 / tan 15° = 3.88 m above; the floor lies 2 m below it.
    const double scale = 3.88 / 5.88 / 1.04;
    CHECK(pixels[0] == Approx(scale * scale / 4 * picture.width * picture.height).epsilon(0.03));
    CHECK(pixels[0] == Approx(pixels[1] * 2 / 3.0).epsilon(0.1));
    CHECK(pixels[2] == 0);
    // The red end is 1.5 m from the middle of the picture, the middle of the green part 0.5 m away in both directions.
    CHECK(std::abs(red.x) == Approx(3 * std::abs(green.x)).epsilon(0.1));
    CHECK(red.x * green.x < 0);
    // From the red end, the green part lies to the right of the room's middle, as seen from above.
    CHECK(-red.x * green.y > 0);

    // Without frames from four sides, whole and through the ceiling, too.
    const Value sides = Value::Map{{"height_px", 100}, {"up", "z"}, {"filter", "bilinear"}, {"samples", 1}};
    testing::TemporaryFolder other;
    std::vector<std::string> names = render_to(other.path(), sides, run, nullptr, room);
    REQUIRE(names == std::vector<std::string>{"views/side_1.png", "views/side_2.png", "views/side_3.png", "views/side_4.png"});
    for (const std::string& name : names)
    {
        const Raster8 side = stored_png::Codec().read_rgb(other.path() / "views" / name);
        std::array<int, 3> seen{}, at_border{};
        for (int y = 0; y < side.height; ++y)
            for (int x = 0; x < side.width; ++x)
                for (std::size_t c = 0; c < 3; ++c)
                    if (side.at(x, y, static_cast<int>(c)) > 200)
                        ++(x == 0 || y == 0 || x + 1 == side.width || y + 1 == side.height ? at_border : seen)[c];
        CHECK(seen[0] > 200);
        CHECK(seen[1] > 200);
        CHECK(seen[2] + at_border[0] + at_border[1] + at_border[2] == 0);
    }
}

TEST_CASE_METHOD(testing::StageTest, "the stage writes one picture per chosen frame")
{
    REQUIRE(render_to(folder.path(), Value::Map{}, run, three_frames()) ==
            std::vector<std::string>{"views/seq-01_frame-0.png", "views/seq-01_frame-1.png", "views/seq-01_frame-2.png"});
    const Raster8 first = stored_png::Codec().read_rgb(folder.path() / "views/views/seq-01_frame-0.png");
    CHECK(first.width == 32);
    CHECK(first.channels == 4);
    CHECK(run.reported.at("empty_views").as_int() == 1);
    CHECK(run.messages.at(0).find("1 of 3 views") != std::string::npos);

    const Value options = Value::Map{{"every_count", 2}, {"height_px", 12}, {"folder", "a/b"}};
    testing::TemporaryFolder other;
    REQUIRE(render_to(other.path(), options, run, three_frames()) ==
            std::vector<std::string>{"a/b/seq-01_frame-0.png", "a/b/seq-01_frame-2.png"});
    CHECK(stored_png::Codec().read_rgb(other.path() / "views/a/b/seq-01_frame-0.png").width == 16);
}

TEST_CASE_METHOD(testing::StageTest, "the stage refuses what it cannot render")
{
    CHECK_THROWS_WITH(render_to(folder.path(), Value::Map{}, run, std::make_shared<Frames>()), Catch::Contains("no frames"));
    auto twice = three_frames();
    twice->frames[1].name = "frame-0";
    CHECK_THROWS_WITH(render_to(folder.path(), Value::Map{}, run, twice), Catch::Contains("seq-01_frame-0.png"));
}
