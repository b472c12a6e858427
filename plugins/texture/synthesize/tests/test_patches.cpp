#include "catch.h"
#include "samples.h"

#include <fresco/error.h>
#include <fresco/testing_scenes.h>

#include <map>
#include <set>

using namespace samples;

namespace
{

bool near(Vec3f a, Vec3f b, float by = 1e-4F)
{
    return length(a - b) < by;
}

const Upright usual{{0, 0, 1}, {1, 0, 0}};

}  // namespace

TEST_CASE("a surface is joined across the seams of its atlas")
{
    // The first has the vertices at the seam twice.
    for (const Mesh& mesh : {turned_wall(0, 1), fresco::testing::two_chart_wall()})
    {
        const PaintedSurface surface(mesh, Progress());
        CHECK(surface.charts.count == 2);
        for (const double scale : surface.uv_per_m)
            CHECK(scale == Approx(0.3));
        for (const Vec3f normal : surface.normals)
            CHECK(near(normal, {0, 0, 1}));
        const auto has = [&](std::size_t face, std::uint32_t other)
        { return std::ranges::find(surface.neighbors[face], other) != surface.neighbors[face].end(); };
        CHECK((has(0, 3) && has(3, 0) && has(0, 1) && !has(1, 2)));
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
            for (const std::uint32_t patch : patches.covers(t))
                across += patches[patch].center.x < 1 && wall.grid.texels()[t].position.x > 1;
        CHECK(across > 0);
    }
}

TEST_CASE("the frame of a patch is orthonormal and its picture upright")
{
    Random random(5);
    for (int i = 0; i < 500; ++i)
    {
        const auto any = [&] { return static_cast<float>(random.normal()); };
        const Vec3f normal = normalized(Vec3f{any(), any(), any()});
        const TangentFrame frame = frame_at(normal, usual);
        CHECK(frame.out == normal);
        CHECK(near(cross(frame.down, frame.right), normal, 1e-5F));
        CHECK(std::abs(dot(frame.right, frame.down)) < 1e-5F);
        CHECK(length(frame.right) == Approx(1));
        // The top is as near to where it has to point as a direction in the plane can be.
        const Vec3f top = std::abs(normal.z) > std::sqrt(0.5F) ? usual.ahead : usual.up;
        CHECK(dot(-frame.down, top) == Approx(length(cross(normal, top))).margin(1e-4));
    }
    CHECK(near(frame_at({0, -1, 0}, usual).right, {1, 0, 0}));
    CHECK(near(frame_at({0, 0, -1}, usual).right, {0, 1, 0}));
    // Neither direction lies in the plane.
    CHECK(length(frame_at({1, 0, 0}, {{1, 0, 0}, {1, 0, 0}}).right) == Approx(1));
}

TEST_CASE("ahead is where most of a room's walls look, and level for any upward direction")
{
    struct Case
    {
        Vec3f size, up, ahead;
    };
    for (const Case& c : {Case{{5, 4, 2.5F}, {0, 0, 1}, {0, 1, 0}}, Case{{4, 5, 2.5F}, {0, 0, 1}, {1, 0, 0}},
                          Case{{2.5F, 4, 5}, {1, 0, 0}, {0, 1, 0}}, Case{{5, 2.5F, 4}, {0, 1, 0}, {0, 0, 1}},
                          // Seen with x upward, floor and ceiling are the largest walls.
                          Case{{5, 4, 2.5F}, {2, 0, 0}, {0, 0, 1}}})
    {
        CAPTURE(c.size.x, c.size.y, c.up.x);
        Mesh mesh = fresco::testing::room(c.size);
        const Upright found = upright(PaintedSurface(mesh, Progress()), c.up);
        CHECK(near(found.up, normalized(c.up)));
        CHECK(near(found.ahead, c.ahead));
        // About z by 25 degrees.
        const auto turn = [](Vec3f p) {
            return Vec3f{0.90630779F * p.x - 0.42261826F * p.y, 0.42261826F * p.x + 0.90630779F * p.y, p.z};
        };
        std::ranges::transform(mesh.positions, mesh.positions.begin(), turn);
        const Upright other = upright(PaintedSurface(mesh, Progress()), turn(c.up));
        CHECK(std::abs(dot(other.ahead, turn(c.ahead))) == Approx(1).margin(1e-5));
        CHECK(dot(other.up, other.ahead) == Approx(0).margin(1e-5));
    }
    // A wall that looks up: nothing is ahead, but there is a direction.
    const Prepared floor(fresco::testing::two_chart_wall(), 0.5, Vec3f{0, 0, 1});
    CHECK(length(floor.upward.ahead) == Approx(1));
    CHECK(dot(floor.upward.ahead, floor.upward.up) == Approx(0).margin(1e-6));
}

TEST_CASE("each point of the surface belongs to one texel")
{
    for (const auto& [turn, spacing] : {std::pair{0.0, 0.05}, {0.4, 0.05}, {1.0, 0.037}, {2.2, 0.037}})
    {
        const Prepared wall(turned_wall(turn, 3), spacing);
        const auto& texels = wall.grid.texels();
        // Turned charts cut cells at their borders: as many are won as lost.
        CHECK(static_cast<double>(texels.size()) == Approx(2 / spacing / spacing).epsilon(0.03));
        double nearest = 1;
        std::set<std::uint32_t> cells;
        std::size_t strangers = 0;
        for (std::size_t a = 0; a < texels.size(); ++a)
        {
            cells.insert(texels[a].cell);
            strangers += wall.grid.texel_at(texels[a].cell) != a;
            strangers += texels[a].position.x < -1e-5F || texels[a].position.x > 2.00001F || texels[a].position.y < -1e-5F ||
                         texels[a].position.y > 1.00001F || texels[a].position.z != 0;
            for (std::size_t b = 0; b < a; ++b)
                if (wall.surface.charts.of_face[texels[a].face] == wall.surface.charts.of_face[texels[b].face])
                    nearest = std::min(nearest, static_cast<double>(length(texels[a].position - texels[b].position)));
        }
        CHECK(cells.size() == texels.size());
        CHECK(strangers == 0);
        CHECK(nearest == Approx(spacing).epsilon(1e-3));
    }
}

TEST_CASE("texels do not depend on the number of faces")
{
    // More faces than are drawn together.
    const Prepared fine(turned_wall(0.4, 200), 0.05);
    const Prepared coarse(turned_wall(0.4, 3), 0.05);
    const auto& texels = fine.grid.texels();
    REQUIRE(texels.size() == coarse.grid.texels().size());
    std::size_t wrong = 0;
    for (std::size_t t = 0; t < texels.size(); ++t)
    {
        wrong += t > 0 && texels[t].cell <= texels[t - 1].cell;
        wrong += std::ranges::count(fine.grid.texels_of(texels[t].face), t) != 1;
        wrong += !near(texels[t].position, coarse.grid.texels()[coarse.grid.texel_at(texels[t].cell)].position, 1e-5F);
    }
    CHECK(wrong == 0);
}

TEST_CASE("cells outside of a chart have the nearest texel of its grid, and a margin lies around")
{
    for (const double turn : {0.0, 0.5, 1.2})
    {
        const Prepared wall(turned_wall(turn, 2), 0.06);
        for (std::uint32_t chart = 0; chart < wall.surface.charts.count; ++chart)
        {
            REQUIRE(wall.grid.has_sheet(chart));
            const SurfaceGrid::Sheet& sheet = wall.grid.sheet(chart);
            const auto texel_of = [&](int x, int y) -> const SurfaceGrid::Texel&
            { return wall.grid.texels()[wall.grid.texel_at(sheet.cell(x, y))]; };
            const auto is_owned = [&](int x, int y) { return texel_of(x, y).cell == sheet.cell(x, y); };
            std::size_t wrong = 0;
            for (int y = 0; y < sheet.height; ++y)
                for (int x = 0; x < sheet.width; ++x)
                {
                    const bool at_border = x == 0 || y == 0 || x + 1 == sheet.width || y + 1 == sheet.height;
                    wrong += at_border && is_owned(x, y);
                    const auto own = static_cast<int>(texel_of(x, y).cell - sheet.first_cell);
                    const int away = std::abs(own % sheet.width - x) + std::abs(own / sheet.width - y);
                    for (int j = 0; j < sheet.height; ++j)
                        for (int i = 0; i < sheet.width; ++i)
                            wrong += is_owned(i, j) && std::abs(i - x) + std::abs(j - y) < away;
                }
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("charts smaller than a texel have one, charts without area none")
{
    Mesh mesh = fresco::testing::two_chart_wall();
    const auto extra = [&](Vec3f across, Vec3f along, float uv_per_m)
    {
        const auto column = static_cast<float>(mesh.triangles.size() - 4) / 20;
        append(mesh, rectangle({5 + 10 * column, 0, 0}, across, along, {0.2F + column, 0.8F}, uv_per_m));
    };
    extra({0.001F, 0, 0}, {0, 0.001F, 0}, 0.3F);
    extra({0.001F, 0, 0}, {0, 0.5F, 0}, 0.3F);
    extra({0.013F, 0, 0}, {0, 0.013F, 0}, 0.3F);
    extra({0, 0, 0}, {0, 0, 0}, 0.3F);        // a point
    extra({0.1F, 0, 0}, {0, 0.1F, 0}, 0.0F);  // nowhere in the atlas
    const Prepared wall(mesh, 0.02);
    std::map<std::uint32_t, std::size_t> texels;
    for (const auto& texel : wall.grid.texels())
        ++texels[wall.surface.charts.of_face[texel.face]];
    REQUIRE(wall.surface.charts.count >= 7);
    CHECK(texels[2] == 1);
    CHECK(texels[3] >= 1);
    CHECK(texels[4] == 1);
    for (std::uint32_t chart = 5; chart < wall.surface.charts.count; ++chart)
    {
        CHECK_FALSE(wall.grid.has_sheet(chart));
        CHECK(texels[chart] == 0);
    }
    // The texel of a chart that holds no cell's center lies in the chart.
    for (const auto& texel : wall.grid.texels())
        if (wall.surface.charts.of_face[texel.face] == 2)
        {
            CHECK(texel.position.x == Approx(5).margin(0.002));
            CHECK(texel.position.y == Approx(0).margin(0.002));
        }
}

TEST_CASE("a surface of absurd size is refused, and says what to do")
{
    testing::TestRun run;
    Mesh huge = fresco::testing::two_chart_wall();
    for (Vec3f& p : huge.positions)
        p = p * 1000;
    Mesh corridor;
    append(corridor, rectangle({}, {700, 0, 0}, {0, 0.5F, 0}, {0.5F, 0.5F}, 0.001F));
    const PaintedSurface surface(corridor, run);
    CHECK_THROWS_WITH(SurfaceGrid(PaintedSurface(huge, run), 0.004, run),
                      Catch::Contains("more than four billion texels") && Catch::Contains("stroke_cm"));
    CHECK_THROWS_WITH(SurfaceGrid(surface, 0.01, run), Catch::Contains("700") && Catch::Contains("65535"));
    run.cancel_after(1);
    CHECK_THROWS_AS(SurfaceGrid(surface, 0.05, run), Canceled);
}

namespace
{

struct Laid : Prepared
{
    Laid(const Mesh& of, double spacing_m, int side, int stride, Vec3f up = {0, 1, 0})
        : Prepared(of, spacing_m, up), patches(surface, grid, upward, side, stride, run), half(side / 2.0)
    {
    }

    /// Position of a point on a patch, in texels from its center.
    Vec2d offset(std::size_t patch, Vec3f point) const
    {
        const Vec3d away = vec_cast<double>(point - patches[patch].center) * (1 / grid.spacing_m());
        return {dot(away, vec_cast<double>(patches[patch].frame.right)), dot(away, vec_cast<double>(patches[patch].frame.down))};
    }

    /// Each patch reaches texels that `allowed(patch's center, texel's position)` admits, and no others.
    template <class Allowed>
    std::size_t strangers(const Allowed& allowed) const
    {
        std::size_t count = 0;
        for (std::size_t t = 0; t < grid.texels().size(); ++t)
            for (const std::uint32_t patch : patches.covers(t))
                count += !allowed(patches[patch].center, grid.texels()[t].position);
        return count;
    }

    Patches patches;
    double half;
};

double farther(Vec2d at)
{
    return std::max(std::abs(at.x), std::abs(at.y));
}

/// Checks properties that covers have on any surface.
void check_covers(const Laid& laid, int stride)
{
    std::size_t far = 0;
    std::size_t unsorted = 0;
    std::size_t misplaced = 0;
    for (std::size_t t = 0; t < laid.grid.texels().size(); ++t)
    {
        double nearest = 1e9;
        const auto covers = laid.patches.covers(t);
        unsorted += std::ranges::adjacent_find(covers, std::ranges::greater_equal()) != covers.end();
        for (const std::uint32_t patch : covers)
        {
            const Vec2d at = laid.offset(patch, laid.grid.texels()[t].position);
            const Vec2f told = laid.patches.offset(patch, laid.grid.texels()[t].position);
            misplaced += farther(at - Vec2d{double{told.x}, double{told.y}}) > 2e-3;
            nearest = std::min(nearest, farther(at));
        }
        far += nearest > stride + 1e-3;
    }
    CHECK(far == 0);
    CHECK(unsorted == 0);
    CHECK(misplaced == 0);
}

/// On a flat wall a point of a patch shows where it lies: exactly inside a chart, within a texel at the chart's rim.
void check_points(const Laid& wall, double least_exact)
{
    std::vector<Vec3f> positions;
    for (const SurfaceGrid::Texel& texel : wall.grid.texels())
        positions.push_back(texel.position);
    const auto away = [&](Vec3f a, Vec3f b) { return length(a - b) / static_cast<float>(wall.grid.spacing_m()); };
    const int side = wall.patches.side();
    std::vector<Vec3f> sampled(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    float worst = 0;
    std::size_t exact = 0;
    std::size_t count = 0;
    for (std::size_t p = 0; p < wall.patches.count(); p += 7)
    {
        const Patch& patch = wall.patches[p];
        wall.patches.sample(wall.grid, positions, p, sampled.data());
        for (int i = 0; i < side * side; ++i)
        {
            const auto along = [&](int at) { return static_cast<float>((at - side / 2) * wall.grid.spacing_m()); };
            const Vec3f point = patch.center + patch.frame.right * along(i % side) + patch.frame.down * along(i / side);
            if (std::ranges::none_of(positions, [&](Vec3f texel) { return away(texel, point) < 0.75F; }))
                continue;
            const float gap = away(sampled[static_cast<std::size_t>(i)], point);
            worst = std::max(worst, gap);
            exact += gap < 0.02F;
            ++count;
        }
    }
    CHECK(worst < 1.5F);
    CHECK(static_cast<double>(exact) >= least_exact * static_cast<double>(count));
}

}  // namespace

TEST_CASE("on a flat wall every patch covers the texels under its square, across the seam")
{
    struct Case
    {
        const char* name;
        Mesh mesh;
        double spacing;
        int side, stride;
        double exact;  ///< Share of the points that do not lie at the rim of a chart.
    };
    // Hardly any of its texels are where the grid has patches.
    Mesh strip;
    append(strip, rectangle({}, {2, 0, 0}, {0, 0.1F, 0}, {0.5F, 0.5F}, 0.3F, 0.3));
    const Case cases[] = {{"two triangles a chart", fresco::testing::two_chart_wall(), 0.02, 11, 4, 1},
                          {"narrow strip", strip, 0.04, 31, 4, 0.4},
                          {"stride 3", fresco::testing::two_chart_wall(), 0.031, 11, 3, 0.98},
                          {"small patches", fresco::testing::two_chart_wall(), 0.05, 5, 4, 1},
                          {"large patches", fresco::testing::two_chart_wall(), 0.04, 31, 4, 1},
                          {"triangles smaller than texels", turned_wall(0, 40), 0.05, 9, 4, 1},
                          {"large triangles, turned", turned_wall(1.3, 1), 0.02, 9, 3, 0.95}};
    for (const Case& c : cases)
    {
        CAPTURE(c.name);
        const Laid wall(c.mesh, c.spacing, c.side, c.stride);
        check_covers(wall, c.stride);
        std::size_t missing = 0;
        std::size_t excess = 0;
        std::size_t across = 0;
        for (std::size_t t = 0; t < wall.grid.texels().size(); ++t)
        {
            const auto& texel = wall.grid.texels()[t];
            const auto covers = wall.patches.covers(t);
            const std::set<std::uint32_t> covering(covers.begin(), covers.end());
            for (std::uint32_t p = 0; p < wall.patches.count(); ++p)
            {
                const double away = farther(wall.offset(p, texel.position));
                if (std::abs(away - wall.half) < 1e-3)
                    continue;
                missing += away < wall.half && !covering.contains(p);
                excess += away > wall.half && covering.contains(p);
                across += covering.contains(p) && (texel.position.x < 1) != (wall.patches[p].center.x < 1);
            }
        }
        CHECK(missing == 0);
        CHECK(excess == 0);
        CHECK(across > 0);
        check_points(wall, c.exact);
    }
}

TEST_CASE("patches reach over gentle bends, not around corners")
{
    for (const int quads : {1, 12})
        for (const int degrees : {20, 40, 75, 90, -90, -30})
        {
            CAPTURE(quads, degrees);
            const Laid floor(bent_floor(degrees * std::numbers::pi / 180, quads), 0.04, 11, 4, Vec3f{0, 0, 1});
            check_covers(floor, 4);
            const std::size_t crossing =
                floor.strangers([](Vec3f center, Vec3f texel) { return (center.y < 0) == (texel.y < 0) || texel.y == 0; });
            if (std::abs(degrees) <= 40)
                CHECK(crossing > 100);
            else if (degrees == 75)
                CHECK(crossing == 0);
            else
                CHECK(floor.strangers([](Vec3f center, Vec3f texel)
                                      { return (std::abs(center.z) < 1e-4F) == (std::abs(texel.z) < 1e-4F); }) == 0);
        }
}

TEST_CASE("patches do not reach surface a centimeter behind, joined by its rim or not")
{
    const auto same_depth = [](Vec3f center, Vec3f texel) { return std::abs(center.z - texel.z) < 0.005F; };
    for (const int quads : {1, 6})
        for (const bool is_back : {false, true})
        {
            Mesh sheets = turned_wall(0, quads);
            const Vec3f corner{is_back ? 1.0F : 0.0F, 0, -0.01F}, across{is_back ? -1.0F : 1.0F, 0, 0};
            append(sheets, rectangle(corner, across, {0, 1, 0}, {0.25F, 0.75F}, 0.3F, 0, quads));
            // The rim of a board: from the front's lower edge to the back's.
            append(sheets, rectangle({0, 0, -0.01F}, {1, 0, 0}, {0, 0, 0.01F}, {0.75F, 0.75F}, 0.3F));
            const Laid laid(sheets, 0.04, 11, 4);
            check_covers(laid, 4);
            CHECK(laid.strangers(
                      [&](Vec3f center, Vec3f texel) {
                          return same_depth(center, texel) || std::abs(texel.z + 0.005F) < 0.0049F ||
                                 std::abs(center.z + 0.005F) < 0.0049F;
                      }) == 0);
        }
}

TEST_CASE("patches reach across a slot only where its sides are joined under them")
{
    // A meter square with a slot of 10 cm from its left side to 20 cm before its right one.
    Mesh sheet = rectangle({}, {1, 0, 0}, {0, 1, 0}, {0.1F, 0.1F}, 0.3F, 0, 10);
    Mesh slotted;
    slotted.positions = sheet.positions;
    for (std::size_t face = 0; face < sheet.triangles.size(); ++face)
    {
        const Triangle& t = sheet.triangles[face];
        const Vec3f middle = (sheet.positions[t[0]] + sheet.positions[t[1]] + sheet.positions[t[2]]) * (1 / 3.0F);
        if (middle.y > 0.4F && middle.y < 0.5F && middle.x < 0.8F)
            continue;
        slotted.triangles.push_back(t);
        for (std::size_t corner = 0; corner < 3; ++corner)
            slotted.texcoords.push_back(sheet.texcoords[3 * face + corner]);
    }
    const Laid laid(slotted, 0.04, 11, 4);
    check_covers(laid, 4);
    const auto crosses = [](Vec3f center, Vec3f texel) { return (center.y < 0.45F) != (texel.y < 0.45F); };
    const auto reaches_right = [](Vec3f center) { return center.x + 5.5F * 0.04F > 0.8F; };
    CHECK(laid.strangers([&](Vec3f center, Vec3f texel) { return !crosses(center, texel) || reaches_right(center); }) == 0);
    CHECK(laid.strangers([&](Vec3f center, Vec3f texel) { return !crosses(center, texel); }) > 40);
}

TEST_CASE("the values of texels that no patch samples do not count")
{
    const Prepared wall(turned_wall(0.4, 3), 0.05);
    const auto& texels = wall.grid.texels();
    std::vector<float> share;
    for (const SurfaceGrid::Texel& texel : texels)
        share.push_back(texel.position.x < 0.6F ? 1.0F : 0.0F);
    const Patches patches(wall.surface, wall.grid, wall.upward, 11, 4, wall.run, {}, share);
    const std::vector<std::uint8_t> sampled = patches.sampled(wall.grid, wall.run);
    std::vector<Vec3f> values;
    for (std::size_t t = 0; t < texels.size(); ++t)
    {
        const float value = sampled[t] != 0 ? 1 : std::numeric_limits<float>::quiet_NaN();
        values.push_back({value, value, value});
        CHECK((sampled[t] != 0 || texels[t].position.x > 0.6F));
        CHECK((sampled[t] == 0 || texels[t].position.x < 1.2F));
    }
    std::vector<Vec3f> found(121);
    for (std::size_t p = 0; p < patches.count(); ++p)
    {
        patches.sample(wall.grid, values, p, found.data());
        CHECK(std::ranges::all_of(found, [](Vec3f v) { return near(v, {1, 1, 1}); }));
    }
}
