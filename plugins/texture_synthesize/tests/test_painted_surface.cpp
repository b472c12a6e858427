#include "catch.h"
#include "samples.h"
#include <fresco/testing_scenes.h>

using namespace samples;

namespace
{

/// The largest difference from what a frame has to be.
float frame_error(const TangentFrame& frame)
{
    float error = 0;
    for (const float off :
         {dot(frame.right, frame.down), dot(frame.right, frame.out), dot(frame.down, frame.out), length(frame.right) - 1,
          length(frame.down) - 1, length(frame.out) - 1, length(cross(frame.down, frame.right) - frame.out)})
        error = std::max(error, std::abs(off));
    return error;
}

bool near(Vec3f a, Vec3f b, float by = 1e-4F)
{
    return length(a - b) < by;
}

Vec3f turned(Vec3f p)
{
    // About z by 25 degrees.
    const float c = 0.90630779F;
    const float s = 0.42261826F;
    return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}

const Upright usual{{0, 0, 1}, {1, 0, 0}};

}  // namespace

TEST_CASE("a surface is joined across the seams of its atlas")
{
    const Mesh split = turned_wall(0, 1);  // The same vertices twice at the seam.
    const Mesh shared = fresco::testing::two_chart_wall();
    for (const Mesh* mesh : {&split, &shared})
    {
        testing::TestRun run;
        const PaintedSurface surface(*mesh, run);
        CHECK(surface.charts.count == 2);
        for (const double scale : surface.uv_per_m)
            CHECK(scale == Approx(0.3));
        for (const Vec3f normal : surface.normals)
            CHECK(near(normal, {0, 0, 1}));
        const auto has = [&](std::size_t face, std::uint32_t other) {
            return std::find(surface.neighbors[face].begin(), surface.neighbors[face].end(), other) !=
                   surface.neighbors[face].end();
        };
        CHECK(has(0, 3));
        CHECK(has(3, 0));
        CHECK(has(0, 1));
        CHECK_FALSE(has(1, 2));
    }
}

TEST_CASE("faces without area do not part the surface")
{
    // A face folded to the seam's edge, as scans have them.
    for (const bool is_folded : {true, false})
    {
        CAPTURE(is_folded);
        Mesh mesh = fresco::testing::two_chart_wall();
        const Vec2f uv{0.5F, 0.9F};
        if (is_folded)
        {
            mesh.positions.push_back(mesh.positions[4]);
            mesh.triangles.push_back({1, 4, 6});
        }
        else
        {
            // The right half has one more vertex on the seam, and a face in a line closes the gap.
            mesh.positions.push_back({1, 0.5F, 0});
            mesh.triangles[3] = {6, 5, 4};
            mesh.triangles.push_back({1, 5, 6});
            const Vec2f middle{0.9F, 0.25F};
            mesh.texcoords[9] = middle;
            mesh.texcoords.insert(mesh.texcoords.end(), {Vec2f{0.9F, 0.4F}, Vec2f{0.6F, 0.1F}, middle});
            mesh.triangles.push_back({1, 6, 4});
        }
        mesh.texcoords.insert(mesh.texcoords.end(), {uv, uv, uv});
        const Prepared wall(mesh, 0.05);
        const Patches patches(wall.surface, wall.grid, wall.upward, 11, 4, wall.run);
        std::size_t across = 0;
        for (std::size_t t = 0; t < wall.grid.texels().size(); ++t)
            for (const Cover& cover : patches.covers(t))
                across += patches[cover.patch].center.x < 1 && wall.grid.texels()[t].position.x > 1;
        CHECK(across > 0);
    }
}

TEST_CASE("the frame of a patch is orthonormal and its picture upright")
{
    Random random(5);
    float worst = 0;
    for (int i = 0; i < 2000; ++i)
    {
        const auto any = [&] { return static_cast<float>(random.normal()); };
        const Vec3f normal = normalized(Vec3f{any(), any(), any()});
        const TangentFrame frame = frame_at(normal, usual);
        worst = std::max(worst, frame_error(frame));
        CHECK(frame.out == normal);
        // The top is as near to where it has to point as a direction in the plane can be.
        const Vec3f top = std::abs(normal.z) > std::sqrt(0.5F) ? usual.ahead : usual.up;
        CHECK(dot(-frame.down, top) == Approx(length(cross(normal, top))).margin(1e-4));
    }
    CHECK(worst < 1e-5F);

    struct Case
    {
        Vec3f normal, right, top;
    };
    for (const Case& c : {Case{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}, Case{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                          Case{{0, 0, 1}, {0, -1, 0}, {1, 0, 0}}, Case{{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}})
    {
        const TangentFrame frame = frame_at(c.normal, usual);
        CHECK(near(frame.right, c.right));
        CHECK(near(frame.down, -c.top));
    }
    CHECK(frame_error(frame_at({1, 0, 0}, {{1, 0, 0}, {1, 0, 0}})) < 1e-5F);
}

TEST_CASE("ahead is where most of a room's walls look")
{
    struct Case
    {
        Vec3f size, up, ahead;
    };
    for (const Case& c : {Case{{5, 4, 2.5F}, {0, 0, 1}, {0, 1, 0}}, Case{{4, 5, 2.5F}, {0, 0, 1}, {1, 0, 0}},
                          Case{{2.5F, 4, 5}, {1, 0, 0}, {0, 1, 0}}, Case{{5, 2.5F, 4}, {0, 1, 0}, {0, 0, 1}}})
    {
        CAPTURE(c.size.x, c.size.y, c.size.z);
        testing::TestRun run;
        Mesh mesh = room(c.size);
        {
            const Upright found = upright(PaintedSurface(mesh, run), c.up);
            CHECK(near(found.up, c.up));
            CHECK(near(found.ahead, c.ahead));
        }
        for (Vec3f& p : mesh.positions)
            p = turned(p);
        const Upright found = upright(PaintedSurface(mesh, run), turned(c.up));
        const auto along = [](Vec3f a, Vec3f b) { return std::abs(dot(a, b)); };
        CHECK(along(found.ahead, turned(c.ahead)) == Approx(1).margin(1e-5));
        CHECK(dot(found.up, found.ahead) == Approx(0).margin(1e-5));
    }
}

TEST_CASE("a given upward direction is taken, and ahead is level")
{
    testing::TestRun run;
    const Mesh mesh = room({5, 4, 2.5F});
    const PaintedSurface surface(mesh, run);
    // Seen with x upward, floor and ceiling are the largest walls.
    const Upright sideways = upright(surface, Vec3f{2, 0, 0});
    CHECK(near(sideways.up, {1, 0, 0}));
    CHECK(near(sideways.ahead, {0, 0, 1}));
    const Upright down = upright(surface, Vec3f{0, 0, -1});
    CHECK(near(down.up, {0, 0, -1}));
    CHECK(near(down.ahead, {0, 1, 0}));
    // A wall that looks up: nothing is ahead, but there is a direction.
    const Prepared floor(fresco::testing::two_chart_wall(), 0.5, Vec3f{0, 0, 1});
    CHECK(length(floor.upward.ahead) == Approx(1));
    CHECK(dot(floor.upward.ahead, floor.upward.up) == Approx(0).margin(1e-6));
}

TEST_CASE("ahead depends on the surface, not on the order of its faces or the run")
{
    testing::TestRun run(4);
    testing::TestRun single(1);
    Mesh mesh = room({5, 4, 2.5F}, 5);
    const Vec3f up{0, 0, 1};
    const Upright first = upright(PaintedSurface(mesh, run), up);
    const Upright second = upright(PaintedSurface(mesh, single), up);
    CHECK(first.ahead == second.ahead);
    std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    std::reverse(mesh.texcoords.begin(), mesh.texcoords.end());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        std::swap(mesh.texcoords[3 * f], mesh.texcoords[3 * f + 2]);
    const Upright reversed = upright(PaintedSurface(mesh, run), up);
    CHECK(near(first.ahead, reversed.ahead, 1e-5F));
}
