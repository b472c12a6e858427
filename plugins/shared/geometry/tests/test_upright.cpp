#include "catch.h"
#include "shapes.h"

#include <fresco/camera.h>
#include <fresco/geometry/upright.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <cmath>
#include <numbers>

using namespace fresco;
using geometry::find_up;
using geometry::turned;
using geometry::UpEvidence;
using geometry::upright_turn;

namespace
{

using Quaternion = std::array<double, 4>;

Quaternion about(Vec3d axis, double degrees)
{
    const double half = degrees * std::numbers::pi / 360;
    const Vec3d v = normalized(axis) * std::sin(half);
    return {v.x, v.y, v.z, std::cos(half)};
}

double degrees_between(Vec3d a, Vec3d b)
{
    return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// A rectangle whose normal is along x × y.
void add_rectangle(Mesh& mesh, Vec3f corner, Vec3f x, Vec3f y)
{
    testing::append(mesh, testing::rectangle(corner, x, y));
}

/// A room of 5 x 4 x 2.4 m seen from inside, z up, with a table; its ceiling is half scanned unless `whole`.
Mesh room(bool whole = false)
{
    Mesh mesh;
    const Vec3f x{5, 0, 0}, y{0, 4, 0}, z{0, 0, 2.4F};
    add_rectangle(mesh, {0, 0, 0}, x, y);
    add_rectangle(mesh, {0, 0, 2.4F}, y, whole ? x : x * 0.5F);
    add_rectangle(mesh, {0, 0, 0}, y, z);
    add_rectangle(mesh, {5, 0, 0}, z, y);
    add_rectangle(mesh, {0, 0, 0}, z, x);
    add_rectangle(mesh, {0, 4, 0}, x, z);
    add_rectangle(mesh, {1, 1, 0.7F}, {1.5F, 0, 0}, {0, 1, 0});
    return mesh;
}

/// The room with a bed, its headboard at a wall.
Mesh furnished(Mesh mesh)
{
    const Vec3f x{2, 0, 0}, y{0, 1.5F, 0}, z{0, 0, 0.5F};
    add_rectangle(mesh, {0, 2, 0.5F}, x, y);
    add_rectangle(mesh, {0, 2, 0}, x, z);
    add_rectangle(mesh, {0, 3.5F, 0}, z, x);
    add_rectangle(mesh, {2, 2, 0}, y, z);
    return mesh;
}

/// Seen from outside, 10 x 6 m with walls of 3 m and a pitched roof of 45 degrees, open at its ends; its ground is a plate that
/// faces down.
Mesh house(bool with_ground)
{
    Mesh mesh;
    const Vec3f x{10, 0, 0}, y{0, 6, 0}, z{0, 0, 3};
    add_rectangle(mesh, {0, 0, 0}, x, z);
    add_rectangle(mesh, {0, 6, 0}, z, x);
    add_rectangle(mesh, {0, 0, 0}, z, y);
    add_rectangle(mesh, {10, 0, 0}, y, z);
    add_rectangle(mesh, {0, 0, 3}, x, {0, 3, 3});
    add_rectangle(mesh, {0, 6, 3}, {0, -3, 3}, x);
    if (with_ground)
        add_rectangle(mesh, {0, 0, 0}, y, x);
    return mesh;
}

Mesh turned_mesh(Mesh mesh, const Quaternion& by)
{
    for (Vec3f& p : mesh.positions)
        p = vec_cast<float>(turned(by, vec_cast<double>(p)));
    return mesh;
}

/// OpenCV axes in a world with z up: turned around z, then looking down; `roll_deg` to the right.
RigidTransform camera(double turn_deg, double down_deg, double roll_deg, const Quaternion& world)
{
    const Quaternion turn = about({0, 0, 1}, turn_deg);
    const Vec3d right = turned(turn, {1, 0, 0});
    const Quaternion tilt = about(right, -down_deg);
    const Vec3d forward = turned(tilt, turned(turn, {0, 1, 0}));
    const Vec3d x = turned(world, turned(about(forward, roll_deg), right));
    const Vec3d z = turned(world, forward);
    const Vec3d y = cross(z, x);
    RigidTransform pose;
    pose.rotation.m = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
    return pose;
}

const Quaternion unturned{0, 0, 0, 1};

/// Asks which way is up.
struct Asking final : Stage
{
    Input<Frames> frames{this, "frames", optional, ""};
    void run(RunContext& /*run*/) override {}
};

/// z up becomes each of the six axes.
std::vector<Quaternion> six_orientations()
{
    const Vec3d x{1, 0, 0}, y{0, 1, 0};
    return {unturned, about(x, 90), about(x, -90), about(x, 180), about(y, 90), about(y, -90)};
}

}  // namespace

TEST_CASE("cameras that look down on one side are off, the floor puts that right")
{
    for (const Quaternion& world : {unturned, about({1, 0, 0}, 90), about({1, 2, 3}, 70), about({3, -1, 1}, 170)})
    {
        const Vec3d up = turned(world, {0, 0, 1});
        std::vector<RigidTransform> poses;
        for (const double turn : {-30.0, -10.0, 10.0, 25.0})
            poses.push_back(camera(turn, 35, 2, world));
        const Vec3d by_cameras = *cameras_up(poses);
        const double off = degrees_between(by_cameras, up);
        CHECK(off > 1);
        const auto found = find_up(turned_mesh(room(), world), by_cameras);
        CHECK(found.from == UpEvidence::cameras_and_plane);
        CHECK(degrees_between(found.direction, up) < 0.01);
        CHECK(found.plane_deg == Approx(off).margin(0.01));
        // The areas are 20 + 10 + 2 * 12 + 2 * 9.6 + 1.5 m2.
        CHECK(found.plane_share == Approx(20 / 74.7).epsilon(1e-4));
    }
}

TEST_CASE("up is up where the ceiling is larger than the floor, or only walls were scanned")
{
    const auto found = find_up(turned_mesh(room(true), about({1, 0, 0}, 180)), normalized(Vec3d{0.1, 0, -1}));
    CHECK(degrees_between(found.direction, {0, 0, -1}) < 0.01);
    Mesh walls = room();
    walls.triangles.erase(walls.triangles.begin(), walls.triangles.begin() + 4);
    walls.triangles.erase(walls.triangles.end() - 2, walls.triangles.end());
    const Vec3d cameras = normalized(Vec3d{0.1, 0.2, 1});
    const auto guessed = find_up(walls, cameras);
    CHECK(guessed.from == UpEvidence::cameras);
    CHECK(degrees_between(guessed.direction, cameras) < 1e-9);
    CHECK(guessed.plane_share == 0);
}

TEST_CASE("phones held upright, upside down recorders and those turned every way")
{
    std::vector<RigidTransform> any;
    for (const double roll : {0.0, 90.0, 180.0, 270.0})
    {
        std::vector<RigidTransform> poses;
        for (double turn = 0; turn < 360; turn += 30)
            poses.push_back(camera(turn, 20, roll, unturned));
        any.insert(any.end(), poses.begin(), poses.end());
        // The picture's left may be up.
        if (roll < 180)
            CHECK(degrees_between(*cameras_up(poses), {0, 0, 1}) < 0.01);
    }
    CHECK_FALSE(cameras_up(any).has_value());
    CHECK_FALSE(cameras_up({}).has_value());
}

TEST_CASE("a mesh that lies or whose sides are alike shows no way up: an axis of its own is kept")
{
    // y where the room stands along it, z where it lies along x.
    for (const auto& [mesh, up] : {std::pair{turned_mesh(room(true), about({1, 0, 0}, 180)), Vec3d{0, 0, 1}},
                                   {turned_mesh(room(true), about({1, 0, 0}, 90)), Vec3d{0, 1, 0}},
                                   {turned_mesh(room(true), about({0, 1, 0}, 90)), Vec3d{0, 0, 1}},
                                   {turned_mesh(room(true), about({1, 0, 0}, 20)), Vec3d{0, 0, 1}},
                                   {shapes::box({}, {1, 1, 1}), Vec3d{0, 0, 1}},
                                   {shapes::sphere(32, 64), Vec3d{0, 0, 1}}})
    {
        const Asking stage;
        testing::TestRun run;
        CHECK(find_up(mesh, std::nullopt).from == UpEvidence::nothing);
        CHECK(geometry::shown_up("auto", mesh, stage.frames, run) == up);
        REQUIRE(run.messages.size() == 1);
        CHECK_THAT(run.messages[0], Catch::Contains("warning: up: auto: the mesh does not clearly show which way is up"));
    }
}

TEST_CASE("a room that lacks a wall and a facade are not laid on their side")
{
    Mesh without_wall = room(true);
    without_wall.triangles.erase(without_wall.triangles.begin() + 6, without_wall.triangles.begin() + 8);
    Mesh facade;
    add_rectangle(facade, {}, {8, 0, 0}, {0, 0, 4});
    add_rectangle(facade, {0, -1, 0}, {8, 0, 0}, {0, 1, 0});
    for (const auto& mesh : {without_wall, furnished(without_wall), room(), facade})
        for (const Quaternion& world : six_orientations())
        {
            const auto found = find_up(turned_mesh(mesh, world), std::nullopt);
            if (found.from != UpEvidence::nothing)
                CHECK(degrees_between(found.direction, turned(world, {0, 0, 1})) < 0.1);
        }
    CHECK(find_up(without_wall, std::nullopt).from == UpEvidence::nothing);
}

TEST_CASE("a recorder that was held upside down is noticed by a furnished room")
{
    for (const double roll : {0.0, 180.0})
    {
        auto frames = std::make_shared<Frames>();
        for (double turn = 0; turn < 360; turn += 30)
            frames->frames.emplace_back().color.world_from_camera = camera(turn, 20, roll, unturned);
        Asking stage;
        stage.frames.set(frames);
        CAPTURE(roll);
        testing::TestRun run;
        const Vec3d up = geometry::shown_up("auto", furnished(room()), stage.frames, run);
        CHECK(degrees_between(up, {0, 0, roll == 0 ? 1.0 : -1.0}) < 0.01);
        REQUIRE(run.messages.size() == (roll == 0 ? 0 : 1));
        if (roll != 0)
            CHECK_THAT(run.messages[0],
                       Catch::Contains("warning: up: from the cameras, along -z, but") && Catch::Contains("set up: z"));
    }
}

TEST_CASE("rooms and buildings stand in any orientation; the ground may be larger than any wall, or missing")
{
    auto orientations = six_orientations();
    orientations.push_back(about({1, 2, 3}, 70));
    for (const Quaternion& world : orientations)
        for (const auto& [name, mesh] :
             {std::pair{"room", furnished(room())}, {"house on a plate", house(true)}, {"house without ground", house(false)}})
        {
            CAPTURE(name, world);
            const auto found = find_up(turned_mesh(mesh, world), std::nullopt);
            CHECK(found.from == UpEvidence::shape);
            CHECK(degrees_between(found.direction, turned(world, {0, 0, 1})) < 0.1);
            CHECK(found.next_share < 0.9);
            CHECK(found.shape_share > 0.4);
        }
}

TEST_CASE("a named axis that a house contradicts warns")
{
    const Asking stage;
    testing::TestRun run;
    CHECK(geometry::shown_up("z", house(false), stage.frames, run) == Vec3d{0, 0, 1});
    CHECK(run.messages.empty());
    CHECK(geometry::shown_up("y", house(false), stage.frames, run) == Vec3d{0, 1, 0});
    REQUIRE(run.messages.size() == 1);
    CHECK_THAT(run.messages[0], Catch::Contains("up: y, but") && Catch::Contains("set up: z"));
}

TEST_CASE("the turn is that of the nearest axis, and changes little where up does")
{
    const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    for (const auto& [up, target] : {std::pair{y, y},
                                     {z, y},
                                     {-y, y},
                                     {y, z},
                                     {-z, z},
                                     {normalized(Vec3d{0.02, -1, 0}), y},
                                     {normalized(Vec3d{-0.01, -1, 0.02}), y},
                                     {normalized(Vec3d{0.01, -1, -0.02}), y}})
    {
        const Quaternion turn = upright_turn(up, target);
        CHECK(degrees_between(turned(turn, up), target) < 1e-5);
        CHECK(degrees_between(turned(turn, x), x) < 3);
    }
    CHECK(degrees_between(turned(upright_turn(x, y), x), y) < 1e-5);
    CHECK(degrees_between(turned(upright_turn(x, y), z), z) < 1e-5);
}
