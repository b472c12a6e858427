#include "catch.h"
#include "furnish.h"
#include "noise.h"
#include "recording.h"
#include "scan_mesh.h"
#include "scene.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using room::Ray;
using room::Shape;
using room::Solid;
using room::Vec3f;

namespace
{

Solid box(Vec3f center, Vec3f half)
{
    Solid s;
    s.shape = Shape::box;
    s.center = center;
    s.size = half;
    return s;
}

/// A room of 2 x 2 x 2 m with a box of 0.5 m in its middle.
room::Scene tiny_scene()
{
    room::Scene scene;
    scene.size = {2, 2, 2};
    scene.materials.push_back({room::Pattern::plaster, {0.2f, 0.2f, 0.2f}, {0.9f, 0.9f, 0.9f}});
    scene.solids = {box({1, 1, 1}, {1, 1, 1}), box({1, 1, 1}, {0.25f, 0.25f, 0.25f})};
    scene.solids.front().hollow = true;
    return scene;
}

Vec3f random_direction(std::uint32_t seed)
{
    return normalized(Vec3f{room::bell(seed), room::bell(seed + 1), room::bell(seed + 2)});
}

}  // namespace

TEST_CASE("the tree of boxes finds what asking every solid finds", "[room]")
{
    const auto scene = room::furnish({4.5f, 3.6f, 2.6f}, 3);
    const room::Caster caster(scene);
    for (std::uint32_t i = 0; i < 3000; ++i)
    {
        const Ray ray{{0.3f + 3.9f * room::unit(i, 1u), 0.3f + 3.0f * room::unit(i, 2u), 1.2f + room::unit(i, 3u)},
                      random_direction(10 * i)};
        float nearest = 1e30f;
        for (const auto& s : scene.solids)
            if (const auto hit = intersect(s, ray, 1e30f); hit.face >= 0)
                nearest = std::min(nearest, hit.t);
        CHECK(caster.cast(ray).t == nearest);
        CHECK(caster.cast(ray, static_cast<int>(i % scene.solids.size())).t == nearest);
        const auto first = caster.cast(ray);
        if (first.solid > 0)
        {
            CHECK(caster.blocked(ray, nearest * 1.01f, -1));
            CHECK_FALSE(caster.blocked(ray, nearest * 0.99f, -1));
        }
    }
}

TEST_CASE("the surface of a box in a box has the area it must have, and no border; a grid that is too fine is refused", "[room]")
{
    auto scene = tiny_scene();
    fresco::testing::TestRun one(1);
    const auto net = room::surface_net(scene, 0.05f, one);
    double volume = 0;
    for (const auto& t : net.triangles)
        volume += static_cast<double>(dot(net.positions[t[0]], cross(net.positions[t[1]], net.positions[t[2]]))) / 6;
    fresco::Mesh mesh;
    mesh.positions = net.positions;
    mesh.triangles = net.triangles;
    const auto counts = fresco::geometry::count_surface(mesh);
    // 6 walls of 4 m2 and 6 faces of 0.25 m2; edges are rounded. Faces look into the air: the enclosed volume counts negative.
    CHECK(counts.area_m2 == Approx(25.5).epsilon(0.02));
    CHECK(volume == Approx(-(8 - 0.125)).epsilon(0.01));
    CHECK(counts.border_edges + counts.complex_edges == 0);
    for (std::size_t i = 0; i < net.positions.size(); ++i)
        CHECK(std::abs(free_distance(scene, net.positions[i])) < 0.012f);
    scene.size = {100, 100, 100};
    CHECK_THROWS_WITH(room::surface_net(scene, 0.01f, one), Catch::Contains("edge_m") && Catch::Contains("60 million"));
}

TEST_CASE("light falls off under things", "[room]")
{
    auto scene = tiny_scene();
    scene.materials.push_back({room::Pattern::shade, {1, 1, 1}, {1, 1, 1}, 1, 0, 5});
    auto lamp = box({1, 1, 1.95f}, {0.2f, 0.2f, 0.03f});
    lamp.materials.fill(1);
    scene.solids.push_back(lamp);
    const room::Caster caster(scene);
    fresco::testing::TestRun run;
    const room::LightMap light(caster, run);
    // On the floor: below the box, and in the open.
    const auto shadow = light.at(0, 4, {1, 1}), open = light.at(0, 4, {1, 0.3f});
    CHECK(shadow.y < 0.7f * open.y);
    CHECK(light.at(1, 5, {0.25f, 0.25f}).y > 2 * light.at(1, 4, {0.25f, 0.25f}).y);
}

TEST_CASE("the two cameras differ and the path keeps clear of the furniture", "[room]")
{
    const auto recorder = room::make_recorder(640, 480, 320, 240);
    CHECK(recorder.color.fx != recorder.depth.scaled_to(640, 480).fx);
    CHECK(length(recorder.color_from_depth.inverse().translation) == Approx(0.025).epsilon(0.02));
    CHECK(recorder.color_from_depth.rotation_error() < 1e-12);
    for (const float length_m : {3.5f, 4.5f, 12.0f})
        for (const float width_m : {3.0f, 8.0f})
        {
            const auto scene = room::furnish({length_m, width_m, 2.4f}, 2);
            for (const auto& pose : room::camera_path(scene, 40, 5))
            {
                CHECK(pose.rotation_error() < 1e-9);
                CHECK(free_distance(scene, fresco::vec_cast<float>(pose.translation)) > 0.15f);
                CHECK(pose.rotation(2, 1) < -0.3);  // The camera's y axis looks down.
            }
        }
}

TEST_CASE("the sensor loses the near and the far, and is exact without noise", "[room]")
{
    fresco::Raster<float> exact(200, 4, 1, 2.0f);
    exact.at(0, 0) = 0.1f;
    exact.at(1, 0) = 20.0f;
    const auto clean = room::sense_depth(exact, 0, 3);
    CHECK((clean.at(0, 0) == 0 && clean.at(1, 0) == 0 && clean.at(5, 1) == 2000));
    const auto noisy = room::sense_depth(fresco::Raster<float>(200, 100, 1, 2.0f), 0.003f, 3);
    double squares = 0;
    for (const auto v : noisy.values)
        squares += (v - 2000.0) * (v - 2000.0);
    // sigma = 0.003 (0.3 + 0.17 * 4) m = 2.94 mm.
    CHECK(std::sqrt(squares / 20000) == Approx(2.94).epsilon(0.05));
}
