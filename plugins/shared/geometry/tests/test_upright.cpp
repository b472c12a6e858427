#include "catch.h"

#include <fresco/camera.h>
#include <fresco/geometry/upright.h>
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
        CHECK(off < 25);
        const auto found = find_up(turned_mesh(room(), world), by_cameras);
        CHECK(found.from == UpEvidence::cameras_and_plane);
        CHECK(degrees_between(found.direction, up) < 0.01);
        CHECK(found.plane_deg == Approx(off).margin(0.01));
        // Of 20 + 10 + 2 * 12 + 2 * 9.6 + 1.5 m2.
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
    const auto up_of = [](double roll)
    {
        std::vector<RigidTransform> poses;
        for (double turn = 0; turn < 360; turn += 30)
            poses.push_back(camera(turn, 20, roll, unturned));
        return cameras_up(poses);
    };
    CHECK(degrees_between(*up_of(0), {0, 0, 1}) < 0.01);
    // The picture's left is up.
    CHECK(degrees_between(*up_of(90), {0, 0, 1}) < 0.01);
    std::vector<RigidTransform> any;
    for (const double roll : {0.0, 90.0, 180.0, 270.0})
        for (double turn = 0; turn < 360; turn += 90)
            any.push_back(camera(turn, 0, roll, unturned));
    CHECK_FALSE(cameras_up(any).has_value());
    CHECK_FALSE(cameras_up({}).has_value());
}

TEST_CASE("a mesh by itself stands on its largest plane, if it is clearly that")
{
    for (const Quaternion& world : {unturned, about({1, 0, 0}, 90), about({1, 2, 3}, 70), about({1, 0, 0}, 180)})
    {
        const auto found = find_up(turned_mesh(room(), world), std::nullopt);
        CHECK(found.from == UpEvidence::planes);
        CHECK(degrees_between(found.direction, turned(world, {0, 0, 1})) < 0.01);
    }
    // Nearly as much faces down as up: which of both is the floor is a guess, along a positive axis.
    const auto whole = find_up(turned_mesh(room(true), about({1, 0, 0}, 180)), std::nullopt);
    CHECK(whole.from == UpEvidence::nothing);
    CHECK(degrees_between(whole.direction, {0, 0, 1}) < 0.01);
    // A cube.
    Mesh cube;
    const Vec3f x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    add_rectangle(cube, {}, x, y);
    add_rectangle(cube, {}, y, z);
    add_rectangle(cube, {}, z, x);
    CHECK(find_up(cube, std::nullopt).from == UpEvidence::nothing);
}

TEST_CASE("the turn is that of the nearest axis, and changes little where up does")
{
    const double half = std::sqrt(0.5);
    const auto near = [](const Quaternion& a, const Quaternion& b)
    {
        double sum = 0;
        for (std::size_t i = 0; i < 4; ++i)
            sum += a[i] * b[i];
        return std::abs(sum) > 1 - 1e-3;
    };
    const Vec3d y{0, 1, 0}, z{0, 0, 1};
    CHECK(near(upright_turn(y, y), {0, 0, 0, 1}));
    CHECK(near(upright_turn(z, y), {-half, 0, 0, half}));
    CHECK(near(upright_turn(-y, y), {1, 0, 0, 0}));
    CHECK(near(upright_turn(y, z), {half, 0, 0, half}));
    CHECK(near(upright_turn(-z, z), {1, 0, 0, 0}));
    CHECK(near(upright_turn({1, 0, 0}, y), {0, 0, half, half}));
    for (const double angle : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0})
    {
        const Vec3d leaning = normalized(Vec3d{0.02 * std::cos(angle), -1, 0.02 * std::sin(angle)});
        CHECK(near(upright_turn(leaning, y), {1, 0, 0, 0}));
        CHECK(degrees_between(turned(upright_turn(leaning, y), leaning), y) < 1e-6);
    }
    CHECK(degrees_between(turned(upright_turn(normalized(Vec3d{1, 2, -3}), z), normalized(Vec3d{1, 2, -3})), z) < 1e-6);
}
