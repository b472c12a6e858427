#include "catch.h"
#include "raw_images.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using testing::RawImages;

namespace
{

/// Outputs of the stage for `options`.
struct Recorded
{
    testing::TestRun run;
    testing::TemporaryFolder out;
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Mesh> mesh;

    explicit Recorded(const Value& options)
    {
        testing::run_stage(FRESCO_PLUGIN_FILE, "scan.synthetic_room", options, {}, out.path(), run,
                           {{"image_io", std::make_shared<RawImages>()}});
        frames = Frames::load({out.path() / "frames", {}});
        mesh = Mesh::load({out.path() / "mesh", {}});
    }
};

Value small(int frames = 6)
{
    return Value::Map{{"frames_count", frames},
                      {"color_width_px", 64},
                      {"color_height_px", 48},
                      {"depth_px", Value::List{80, 60}},
                      {"edge_m", 0.06}};
}

/// One recording for the tests that only look at it.
const Recorded& recorded()
{
    static const Recorded room(small());
    return room;
}

}  // namespace

TEST_CASE("a room has frames of two cameras and a colored mesh that fits inside", "[scan.synthetic_room]")
{
    const Recorded& result = recorded();
    REQUIRE(result.frames->frames.size() == 6);
    const RawImages images;
    for (const auto& frame : result.frames->frames)
    {
        const auto apart = frame.color.world_from_camera.translation - frame.depth.world_from_camera.translation;
        CHECK(length(apart) == Approx(0.0251).epsilon(0.01));
        CHECK(frame.color.intrinsics.scaled_to(80, 60).fx != Approx(frame.depth.intrinsics.fx).epsilon(0.05));
        const auto color = load_color(frame, &images);
        const auto [dark, light] = std::minmax_element(color.values.begin(), color.values.end());
        CHECK(*light - *dark > 100);
    }
    CHECK(result.mesh->triangles.size() > 10'000);
    for (const auto& p : result.mesh->positions)
        CHECK((p.x > -0.03f && p.y > -0.03f && p.z > -0.03f && p.x < 4.53f && p.y < 3.63f && p.z < 2.63f));
}

TEST_CASE("mesh, depth and pictures agree within the noise, but only through their own cameras", "[scan.synthetic_room]")
{
    const Recorded& result = recorded();
    const RawImages images;
    std::size_t compared = 0, in_front = 0, moved = 0;
    double right = 0, wrong = 0;
    for (const auto& frame : result.frames->frames)
    {
        const auto color = load_color(frame, &images);
        const auto depth = load_depth(frame, &images);
        for (std::size_t i = 0; i < result.mesh->positions.size(); ++i)
        {
            const auto world = vec_cast<double>(result.mesh->positions[i]);
            const auto d = frame.depth.project(world), c = frame.color.project(world);
            if (!(d.z > 0.4 && d.x >= 0 && d.y >= 0 && d.x < 80 && d.y < 60 && c.x >= 0 && c.y >= 0 && c.x < 64 && c.y < 48))
                continue;
            const double beyond = d.z - static_cast<double>(depth.at(static_cast<int>(d.x), static_cast<int>(d.y)));
            in_front += beyond < -0.2 && beyond > -d.z ? 1 : 0;
            if (std::abs(beyond) > 0.03)
                continue;  // Hidden behind what the camera sees, or beside an edge.
            ++compared;
            moved += std::abs(c.x - d.x * 64 / 80) > 1 ? 1 : 0;
            const auto difference = [&](double x, double y)
            {
                return std::abs(static_cast<double>(color.at(static_cast<int>(x), static_cast<int>(y), 1)) -
                                static_cast<double>(result.mesh->colors[i][1]));
            };
            right += difference(c.x, c.y);
            wrong += difference(d.x * 64 / 80, d.y * 48 / 60);
        }
    }
    REQUIRE(compared > 2000);
    CHECK(in_front < compared / 20);
    CHECK(moved > compared / 2);
    CHECK(right / static_cast<double>(compared) < 22);
    CHECK(wrong > 1.25 * right);
}

TEST_CASE("unseen surfaces are left out, and noise can be switched off", "[scan.synthetic_room]")
{
    auto options = small(2);
    options.set("noise_m", 0.0);
    const Recorded seen(options);
    CHECK(seen.run.reported.at("unseen_share").as_double() > 0.2);
    options.set("seed", 2);
    CHECK(Recorded(options).mesh->positions != seen.mesh->positions);
    // Without noise the floor is exactly at 0.
    std::size_t on_floor = 0;
    for (const auto& p : seen.mesh->positions)
        on_floor += std::abs(p.z) < 1e-4f ? 1 : 0;
    CHECK(on_floor > 100);
}

TEST_CASE("a room that cannot be furnished is refused with its limits", "[scan.synthetic_room]")
{
    const auto refused = [](const char* name, Value value, const char* word)
    {
        Value options = small(2);
        options.set(name, std::move(value));
        CHECK_THROWS_WITH(Recorded(options), Catch::Contains(word));
    };
    refused("size_m", Value::List{4, 3}, "is [4, 3]; expected [length, width, height]");
    refused("size_m", Value::List{4, 9, 2.5}, "width from 3 to 8");
    refused("depth_px", Value::List{80}, "expected [width, height]");
}
