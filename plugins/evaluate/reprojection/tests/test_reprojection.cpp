#include "catch.h"
#include "judged_views.h"
#include "pair_figures.h"
#include "plugin_under_test.h"

#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using fresco::testing::picture;

namespace
{

// A wall z = 2 m over x, y in [-3, 3] m that faces the cameras, which look along z: a pixel is 2 cm at 100 px focal length.

TexturedMesh wall(Raster8 picture)
{
    TexturedMesh textured;
    textured.mesh = fresco::testing::wall(3);
    textured.image = Image(std::move(picture));
    return textured;
}

/// Moved by (x, y) px of the wall's picture in it, and forwards by z meters.
Camera camera(int width, int height, double x_px, double y_px, double z = 0)
{
    return fresco::testing::camera(width, height, 100, {x_px * 0.02, y_px * 0.02, z});
}

/// Surface of the wall as a camera that looks along z sees it, without ray casting.
ViewSurface surface(const Camera& camera)
{
    const int width = camera.intrinsics.width;
    const int height = camera.intrinsics.height;
    const auto depth = static_cast<float>(2 - camera.world_from_camera.translation.z);
    ViewSurface view{camera, RasterF(width, height, 1, depth), Raster8(width, height), Raster<std::uint32_t>(width, height)};
    find_inner_pixels(view);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const Vec3d p = view.point(x, y);
            view.triangles.at(x, y) = p.x > p.y ? 0 : 1;  // the diagonal x = y parts them
        }
    return view;
}

/// The wall's picture seen at pixel centers, bilinear, without mip-maps.
Raster8 render(const TexturedMesh& textured, const Camera& camera)
{
    const rendering::MipMaps maps(textured.image.pixels, rendering::TextureFilter::bilinear);
    const double depth = 2 - camera.world_from_camera.translation.z;
    return picture(camera.intrinsics.width, camera.intrinsics.height,
                   [&](int x, int y, int c)
                   {
                       const Vec3d p = camera.world_from_camera.translation + camera.ray(x + 0.5, y + 0.5) * depth;
                       const Vec3d color = maps.sample({(p.x + 3) / 6, 1 - (p.y + 3) / 6}, 0);
                       return c == 0 ? color.x : c == 1 ? color.y : color.z;
                   });
}

}  // namespace

TEST_CASE("a camera that moves by pixels finds points that many pixels back")
{
    const ViewSurface source = surface(camera(40, 30, 0, 0));
    const auto matches = covisible(source, surface(camera(40, 30, 3, 0.25)));
    CHECK(matches.size() == 37 * 29);  // three columns leave, and the first row lies above the first centers
    for (const Match& match : matches)
    {
        CHECK(match.target.x.first + match.target.x.share == Approx(match.x - 3));
        CHECK(match.target.y.first + match.target.y.share == Approx(match.y - 0.25));
        CHECK(match.target.y.second == match.target.y.first + 1);
    }
    // Twice as near: half of the picture, every other pixel of the target.
    const auto nearer = covisible(source, surface(camera(40, 30, 0, 0, 1)));
    for (const Match& match : nearer)
        CHECK(match.target.x.first + match.target.x.share == Approx(2 * (match.x + 0.5 - 20) + 20 - 0.5));
    CHECK(nearer.size() == 20 * 14);  // half a row more on either side would lie beyond the outermost centers
}

TEST_CASE("a point is seen where the target's depth agrees within 2 % and 1 cm at all pixels that contribute")
{
    const ViewSurface source = surface(camera(20, 20, 0, 0));
    const auto count = [&](float depth)
    {
        ViewSurface target = source;
        for (float& d : target.depth.values)
            d = depth;
        return covisible(source, target).size();
    };
    CHECK(count(2.049F) == 400);
    CHECK(count(2.051F) == 0);
    CHECK(count(1.949F) == 0);
    ViewSurface target = surface(camera(20, 20, 0.5, 0));
    target.depth.at(10, 10) = 1.5F;  // something stands before the wall
    const auto matches = covisible(source, target);
    CHECK(matches.size() == 19 * 20 - 2);
    for (const Match& match : matches)
        CHECK_FALSE((match.y == 10 && (match.x == 10 || match.x == 11)));
}

TEST_CASE("pixels beside a hole are left out in both pictures, and surface behind the target's camera")
{
    const ViewSurface whole = surface(camera(20, 20, 0, 0));
    ViewSurface holed = whole;
    holed.depth.at(10, 10) = 0;
    find_inner_pixels(holed);
    CHECK(covisible(holed, whole).size() == 400 - 9);
    CHECK(covisible(whole, holed).size() == 400 - 9);
    holed.camera.world_from_camera.translation = {0, 0, 3};
    CHECK(covisible(whole, holed).empty());
}

TEST_CASE("pairs are recorded numbers apart, within a sequence")
{
    const std::vector<FramePlace> recorded{{"a", 0}, {"a", 8}, {"a", 16}, {"a", 24}, {"a", 40}, {"b", 8}, {"b", 48}};
    CHECK(frame_pairs(recorded, 8) == std::vector<FramePair>{{0, 1}, {1, 2}, {2, 3}});
    CHECK(frame_pairs(recorded, 24) == std::vector<FramePair>{{0, 3}, {2, 4}});
    CHECK(frame_pairs(recorded, 40) == std::vector<FramePair>{{0, 4}, {5, 6}});
    CHECK(frame_pairs(recorded, 2).empty());
}

namespace
{
constexpr int width = 60;
constexpr int height = 50;
/// The first camera of the pairs below.
const Camera a = camera(width, height, 0, 0);

PairFigures judge(const Camera& a, const Raster8& picture_a, const Camera& b, const Raster8& picture_b,
                  const TexturedMesh& textured, const SurfacePaint& paint)
{
    return judge_pair({0, 1}, {surface(a), picture_a}, {surface(b), picture_b}, textured.mesh, paint, 0.2, Progress{});
}

/// The figures of the wall's pictures at both cameras; without a paint, the floor is that of the first picture.
PairFigures judge(const Camera& a, const Camera& b, const TexturedMesh& textured, const SurfacePaint& paint)
{
    return judge(a, render(textured, a), b, render(textured, b), textured, paint);
}

}  // namespace

TEST_CASE("a ramp moved by one pixel against its camera differs by its slope")
{
    const TexturedMesh textured = wall(Raster8(8, 8, 3));
    const Camera c = camera(width, height, 0, 0);
    const auto ramp = [](int moved)
    { return picture(width, height, [=](int x, int y, int) { return 2 * (x + moved) + 2 * y; }); };
    const PairFigures paper = judge(c, ramp(0), c, ramp(1), textured, {});
    CHECK(paper.value == Approx(2 / 255.0));
    CHECK(paper.floor == 0);
    CHECK(paper.detail == Approx(2 / 255.0));
    CHECK(paper.headline == Approx(1));
    CHECK(paper.sharpness == Approx(0).margin(1e-9));
}

TEST_CASE("detail and sharpness of a checkerboard")
{
    const Raster8 board = picture(10, 10, [](int x, int y, int) { return (x + y) % 2 == 0 ? 255 : 0; });
    const ViewSurface view = surface(camera(10, 10, 0, 0));
    const auto matches = covisible(view, view);
    CHECK(forward_difference(board, matches) == Approx(1));
    CHECK(sharpness(board, matches) == Approx(1020.0 * 1020));
    CHECK(std::isnan(reprojection_difference(board, board, {})));
    CHECK(std::isnan(sharpness(board, {})));
}

TEST_CASE("consistent pictures stay at the floor")
{
    const TexturedMesh textured = wall(testing::noise_picture(300, 300, 2));  // a texel is a pixel
    const Camera b = camera(width, height, 2.5, 0.25);
    const PairFigures figures = judge(a, b, textured, texture_paint(textured));
    CHECK(figures.value > 0.02);
    CHECK(figures.floor == Approx(figures.value).epsilon(0.01));
    CHECK(figures.headline == Approx(0).margin(0.01));
    // Seen from twice as far without mip-maps the texture aliases; the floor is of what neither camera undersamples.
    const Camera far = camera(width, height, 0.25, 0.25, -2);
    const PairFigures aliased = judge(a, far, textured, texture_paint(textured));
    CHECK(aliased.floor < 0.7 * aliased.value);
    CHECK(aliased.headline > 0.2);
    CHECK(judge(a, far, textured, {}).floor < 0.7 * aliased.value);
}

TEST_CASE("the floor is lit as the judged pictures are")
{
    const TexturedMesh textured = wall(testing::noise_picture(300, 300, 1));
    const Camera b = camera(width, height, 3.5, 1.5, 0.1);
    const auto judged = [&](const char* shading)
    { return judge(a, b, textured, texture_paint(textured, rendering::lights_of(shading))); };
    // The wall looks away from the lamp: only the ambient light is left.
    CHECK(judged("none").floor > 0.01);
    CHECK(judged("scannet").floor == Approx(0.4 * judged("none").floor).epsilon(0.02));
}

TEST_CASE("blur and less contrast improve the value but not the headline")
{
    // Each view is painted on its own: the second one's pattern lies 0.6 px away from where it should.
    const Raster8 pattern = testing::noise_picture(300, 300, 3);
    const Camera b = camera(width, height, 2.25, 0);
    const Camera wrong = camera(width, height, 2.85, 0.2);
    for (const bool texture_floor : {false, true})
    {
        const auto of = [&](const Raster8& texture)
        {
            const TexturedMesh textured = wall(texture);
            return judge(a, render(textured, a), b, render(textured, wrong), textured,
                         texture_floor ? texture_paint(textured) : SurfacePaint());
        };
        const PairFigures plain = of(pattern);
        const PairFigures blur = of(resized(resized(pattern, 60, 60), 300, 300));
        const PairFigures half = of(picture(300, 300, [&](int x, int y, int c) { return 64 + pattern.at(x, y, c) / 2.0; }));
        CHECK(plain.headline > 0.1);
        CHECK(blur.value < 0.5 * plain.value);
        CHECK(blur.sharpness < 0.1 * plain.sharpness);
        CHECK(blur.headline >= plain.headline);
        CHECK(half.value == Approx(plain.value / 2).epsilon(0.02));
        CHECK(half.headline == Approx(plain.headline).epsilon(0.02));
    }
}

TEST_CASE("pairs with too little in common are dropped and counted")
{
    const TexturedMesh textured = wall(testing::noise_picture(300, 300, 7));
    const auto pair_at = [&](double moved)
    { return judge(a, camera(width, height, moved, 0), textured, texture_paint(textured)); };
    const PairFigures kept = pair_at(47);     // 13 of 60 columns
    const PairFigures dropped = pair_at(49);  // 11 of 60: less than 20 %
    CHECK_FALSE(kept.dropped);
    CHECK(dropped.dropped);
    const GapFigures all = summary({kept, dropped, kept}, {.resamples = 2000, .seed = 1});
    CHECK(all.kept == 2);
    CHECK(all.dropped == 1);
    CHECK(all.flat == 0);
    CHECK_FALSE(all.invalid);
    CHECK(all.figures[0].value == Approx(kept.value));
    CHECK(summary({dropped}, {.resamples = 2000, .seed = 1}).invalid);
}

namespace
{
/// Six recorded frames, numbers 0, 8, …, 40, that move by 2.5 px each, and their renders.
struct Recording : JudgedViews
{
    Recording()
    {
        for (int i = 0; i < 6; ++i)
        {
            const Frame frame = testing::frame("frame-" + std::to_string(8 * i), camera(48, 36, 2.5 * i, 0.3 * i), 8 * i);
            add(frame, render(*textured, frame.color));
        }
    }

    testing::Inputs rendered() const { return {{"views", views}, {"frames", frames}, {"textured_mesh", textured}}; }

    static Value judge(const Value& options, const testing::Inputs& inputs, testing::TestRun& run)
    {
        return parse_json(JudgedViews::judge("evaluate.reprojection", options, inputs, run));
    }

    std::shared_ptr<TexturedMesh> textured = std::make_shared<TexturedMesh>(wall(testing::noise_picture(300, 300, 1)));
};

/// Options with gaps that the recording has.
Value with_gaps(Value::Map more = {})
{
    more.emplace_back("gaps", Value::List{8, 24});
    return more;
}

struct JudgeTest : testing::StageTest
{
    Recording recording;
};
}  // namespace

TEST_CASE_METHOD(JudgeTest, "the stage judges renders by gaps in recorded numbers, and every n-th picture as the whole run does")
{
    const Value figures = recording.judge(with_gaps(), recording.rendered(), run);
    CHECK(figures.at("floor_of").as_string() == "texture");
    CHECK(figures.at("short").at("pairs").as_int() == 5);
    CHECK(figures.at("short").at("frames_without_target").as_int() == 1);
    CHECK(figures.at("long").at("pairs").as_int() == 3);
    CHECK(figures.at("long").at("pair_figures").as_list().size() == 3);
    const Value& value = figures.at("short").at("value");
    CHECK(value.at("value").as_double() > 0.02);
    CHECK(std::abs(figures.at("short").at("headline").at("value").as_double()) < 0.01);
    CHECK(run.reported.at("short_value").at("value") == value.at("value"));
    CHECK(run.reported.at("long_dropped_pairs").as_int() == 0);
    CHECK(std::ranges::any_of(run.messages, [](const auto& line) { return line.starts_with("short value 0."); }));
    const Value some = recording.judge(with_gaps({{"every", 2}}), recording.rendered(), run);
    CHECK(some.at("short").at("pairs").as_int() == 3);
    CHECK(some.at("short").at("frames_without_target").as_int() == 1);
    CHECK(some.at("short").at("pair_figures").as_list()[1] == figures.at("short").at("pair_figures").as_list()[2]);
}

TEST_CASE_METHOD(JudgeTest, "a flat texture is warned about")
{
    for (const std::string& name : recording.views->names)
        write_file(recording.views_folder.path() / name, stored_png::Codec().encode_png(Raster8(48, 36, 3, 77)));
    const Value figures = recording.judge(with_gaps(), recording.rendered(), run);
    CHECK(figures.at("short").at("invalid").as_bool());
    CHECK(figures.at("short").at("headline").at("value").is_null());
    CHECK(std::ranges::any_of(run.messages,
                              [](const auto& line) { return line.starts_with("warning: the short figures are invalid"); }));
}

TEST_CASE_METHOD(JudgeTest, "the stage refuses what it cannot judge")
{
    CHECK_THROWS_WITH(recording.judge(Value::Map{}, recording.rendered(), run), Catch::Contains("smallest difference is 8"));
    auto inputs = recording.rendered();
    inputs.erase("textured_mesh");
    CHECK_THROWS_WITH(recording.judge(with_gaps(), inputs, run), Catch::Contains("wire one of the ports"));
    inputs["mesh"] = std::make_shared<Mesh>(recording.textured->mesh);
    CHECK(recording.judge(with_gaps(), inputs, run).at("floor_of").as_string() == "picture");
    CHECK_THROWS_WITH(recording.judge(with_gaps({{"floor", "texture"}}), inputs, run), Catch::Contains("choose floor: picture"));
}
