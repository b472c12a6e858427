#include "catch.h"
#include "samples.h"
#include "two_chart_wall.h"

#include <set>

using namespace samples;

namespace
{

struct Laid : Prepared
{
    Laid(const Mesh& of, double spacing_m, int side, int stride, Vec3f up = {0, 1, 0})
        : Prepared(of, spacing_m, up), patches(surface, grid, upward, side, stride, run), half(side / 2.0)
    {
    }

    /// Where a point lies on a patch, in texels from its center.
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
            for (const Cover& cover : patches.covers(t))
                count += !allowed(patches[cover.patch].center, grid.texels()[t].position);
        return count;
    }

    Patches patches;
    double half;
};

double farther(Vec2d at)
{
    return std::max(std::abs(at.x), std::abs(at.y));
}

/// What is to hold on any surface.
void check_covers(const Laid& laid, int stride)
{
    std::size_t bare = 0;
    std::size_t far = 0;
    std::size_t unsorted = 0;
    std::size_t misplaced = 0;
    for (std::size_t t = 0; t < laid.grid.texels().size(); ++t)
    {
        double nearest = 1e9;
        const auto covers = laid.patches.covers(t);
        bare += covers.empty();
        for (std::size_t i = 0; i < covers.size(); ++i)
        {
            unsorted += i > 0 && covers[i - 1].patch >= covers[i].patch;
            const Vec2d at = laid.offset(covers[i].patch, laid.grid.texels()[t].position);
            const Vec2f told = covers[i].offset();
            misplaced +=
                std::abs(at.x - static_cast<double>(told.x)) > 2e-3 || std::abs(at.y - static_cast<double>(told.y)) > 2e-3;
            nearest = std::min(nearest, farther(at));
        }
        far += nearest > stride + 1e-3;
    }
    CHECK(bare == 0);
    CHECK(far == 0);
    CHECK(unsorted == 0);
    CHECK(misplaced == 0);
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
    };
    // Hardly any of its texels are where the grid has patches.
    Mesh strip;
    add(strip, rectangle({}, {2, 0, 0}, {0, 0.1F, 0}, {0.5F, 0.5F}, 0.3F, 0.3));
    const Case cases[] = {{"two triangles a chart", two_chart_wall(), 0.02, 11, 4},
                          {"narrow strip", strip, 0.04, 31, 4},
                          {"stride 3", two_chart_wall(), 0.031, 11, 3},
                          {"small patches", two_chart_wall(), 0.05, 5, 4},
                          {"patches a stride apart", two_chart_wall(), 0.04, 7, 4},
                          {"large patches", two_chart_wall(), 0.04, 31, 4},
                          {"triangles smaller than texels", turned_wall(0, 40), 0.05, 9, 4},
                          {"turned in the atlas", turned_wall(0.4, 2), 0.03, 11, 4},
                          {"large triangles, turned", turned_wall(1.3, 1), 0.02, 9, 3}};
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
            std::set<std::uint32_t> covering;
            for (const Cover& cover : wall.patches.covers(t))
                covering.insert(cover.patch);
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
    }
}

TEST_CASE("patches have their centers on the grid and hang upright")
{
    const Laid wall(two_chart_wall(), 0.05, 11, 4);
    std::set<std::uint32_t> at;
    for (std::size_t p = 0; p < wall.patches.count(); ++p)
    {
        const Patch& patch = wall.patches[p];
        CHECK(patch.center == wall.grid.texels()[patch.texel].position);
        CHECK(length(patch.frame.right - Vec3f{1, 0, 0}) < 1e-5F);
        CHECK(length(patch.frame.down - Vec3f{0, -1, 0}) < 1e-5F);
        CHECK(at.insert(patch.texel).second);
    }
    // 20 x 20 texels a chart: 5 x 5 patches and what their borders need.
    CHECK(wall.patches.count() >= 50);
    CHECK(wall.patches.count() <= 72);
}

TEST_CASE("patches reach over gentle bends, not around corners")
{
    struct Case
    {
        double degrees;
        bool is_crossed;
    };
    for (const int quads : {1, 12})
        for (const Case& c :
             {Case{20, true}, Case{40, true}, Case{75, false}, Case{90, false}, Case{-90, false}, Case{-30, true}})
        {
            CAPTURE(quads, c.degrees);
            const Laid floor(bent_floor(c.degrees * std::numbers::pi / 180, quads), 0.04, 11, 4, Vec3f{0, 0, 1});
            check_covers(floor, 4);
            const std::size_t crossing =
                floor.strangers([](Vec3f center, Vec3f texel) { return (center.y < 0) == (texel.y < 0) || texel.y == 0; });
            if (c.is_crossed)
                CHECK(crossing > 100);
            else if (c.degrees == 75)
                CHECK(crossing == 0);
            else
                CHECK(floor.strangers([](Vec3f center, Vec3f texel)
                                      { return (std::abs(center.z) < 1e-4F) == (std::abs(texel.z) < 1e-4F); }) == 0);
        }
    const Laid inside(room({1.5F, 1.2F, 1}, 4), 0.05, 11, 4, Vec3f{0, 0, 1});
    check_covers(inside, 4);
    std::size_t around = 0;
    for (std::size_t t = 0; t < inside.grid.texels().size(); ++t)
        for (const Cover& cover : inside.patches.covers(t))
            around += inside.surface.charts.of_face[inside.grid.texels()[t].face] !=
                      inside.surface.charts.of_face[inside.grid.texels()[inside.patches[cover.patch].texel].face];
    CHECK(around == 0);
}

TEST_CASE("patches do not reach surface a centimeter behind, joined by its rim or not")
{
    const auto same_depth = [](Vec3f center, Vec3f texel) { return std::abs(center.z - texel.z) < 0.005F; };
    for (const int quads : {1, 6})
        for (const bool is_back : {false, true})
        {
            Mesh sheets = turned_wall(0, quads);
            Rectangle behind = rectangle({0, 0, -0.01F}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.75F}, 0.3F, 0, quads);
            if (is_back)
            {
                behind.corner = {1, 0, -0.01F};
                behind.across = {-1, 0, 0};
            }
            add(sheets, behind);
            // The rim of a board: from the front's lower edge to the back's.
            add(sheets, rectangle({0, 0, -0.01F}, {1, 0, 0}, {0, 0, 0.01F}, {0.75F, 0.75F}, 0.3F));
            const Laid laid(sheets, 0.04, 11, 4);
            check_covers(laid, 4);
            CHECK(laid.strangers(
                      [&](Vec3f center, Vec3f texel) {
                          return same_depth(center, texel) || std::abs(texel.z + 0.005F) < 0.0049F ||
                                 std::abs(center.z + 0.005F) < 0.0049F;
                      }) == 0);
        }
    // A step of a centimeter in a wall.
    Mesh step;
    add(step, rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F));
    add(step, rectangle({1, 0, 0}, {0, 0, 0.01F}, {0, 1, 0}, {0.5F, 0.25F}, 0.3F));
    add(step, rectangle({1, 0, 0.01F}, {1, 0, 0}, {0, 1, 0}, {0.75F, 0.25F}, 0.3F));
    const Laid laid(step, 0.04, 11, 4);
    check_covers(laid, 4);
    CHECK(laid.strangers([](Vec3f center, Vec3f texel)
                         { return (center.x < 1) == (texel.x < 1) || center.x == 1 || texel.x == 1; }) == 0);
}

TEST_CASE("sampling a linear field of position gives it back, and points off the surface have the nearest one's")
{
    struct Case
    {
        const char* name;
        Mesh mesh;
        double spacing;
        int side;
    };
    const Case cases[] = {{"two triangles a chart", two_chart_wall(), 0.03, 11},
                          {"small triangles", turned_wall(0, 40), 0.05, 9},
                          {"turned in the atlas", turned_wall(0.4, 3), 0.04, 11},
                          {"wall smaller than a patch", turned_wall(0, 1), 0.2, 15}};
    const auto field = [](Vec3f p) { return Vec3f{p.x, p.y, 1 + p.x - 2 * p.y}; };
    for (const Case& c : cases)
    {
        CAPTURE(c.name);
        const Laid wall(c.mesh, c.spacing, c.side, 4);
        const auto one = static_cast<float>(c.spacing);
        std::vector<Vec3f> values;
        for (const auto& texel : wall.grid.texels())
            values.push_back(field(texel.position));
        const auto side = static_cast<std::size_t>(c.side);
        std::vector<Vec3f> sampled(side * side);
        float inner = 0;
        float border = 0;
        std::size_t wrong = 0;
        std::size_t outside = 0;
        for (std::size_t p = 0; p < wall.patches.count(); ++p)
        {
            wall.patches.sample(wall.grid, values, p, sampled.data());
            const auto point = [&](std::size_t i)
            {
                const Patch& patch = wall.patches[p];
                const auto along = [&](std::size_t k) { return (static_cast<float>(k) - static_cast<float>(side / 2)) * one; };
                return patch.center + patch.frame.right * along(i % side) + patch.frame.down * along(i / side);
            };
            // How far inside of its half of the wall a point lies.
            const auto depth = [](Vec3f at) { return std::min({at.y, 1 - at.y, at.x, 2 - at.x, std::abs(at.x - 1)}); };
            const auto is_on_wall = [](Vec3f at) { return at.x > -1e-5F && at.x < 2.00001F && at.y > -1e-5F && at.y < 1.00001F; };
            for (std::size_t i = 0; i < sampled.size(); ++i)
            {
                const Vec3f at = point(i);
                if (is_on_wall(at))
                {
                    float& worst = depth(at) > 1.5F * one ? inner : border;
                    worst = std::max(worst, length(sampled[i] - field(at)));
                    continue;
                }
                ++outside;
                float least = 1e9F;
                for (std::size_t k = 0; k < sampled.size(); ++k)
                    if (is_on_wall(point(k)))
                        least = std::min(least, length(point(k) - at));
                bool has_match = false;
                for (std::size_t k = 0; k < sampled.size(); ++k)
                    has_match = has_match ||
                                (is_on_wall(point(k)) && length(point(k) - at) < least + 1e-4F * one && sampled[k] == sampled[i]);
                wrong += !has_match;
            }
        }
        // In steps of 1 / 256 texel, and at a chart's border the texel beside it.
        CHECK(inner <= one * 3 / 200);
        CHECK(border <= one * 3);
        CHECK(outside > 0);
        CHECK(wrong == 0);
    }
}

TEST_CASE("patches are the same for any number of threads")
{
    Mesh mesh = room({1.5F, 1.2F, 1}, 6);
    Random random(3);
    for (Vec3f& p : mesh.positions)
        p.z += static_cast<float>(0.01 * std::sin(7 * p.x + 5 * p.y));
    const Prepared box(mesh, 0.02, Vec3f{0, 0, 1});
    testing::TestRun single(1);
    testing::TestRun five(5);
    const Patches a(box.surface, box.grid, box.upward, 9, 4, single);
    const Patches b(box.surface, box.grid, box.upward, 9, 4, five);
    REQUIRE(a.count() == b.count());
    std::vector<Vec3f> values;
    std::size_t different = 0;
    for (std::size_t t = 0; t < box.grid.texels().size(); ++t)
    {
        values.push_back({static_cast<float>(random.uniform()), 0, 1});
        different +=
            !std::ranges::equal(a.covers(t), b.covers(t),
                                [](const Cover& c, const Cover& d) { return c.patch == d.patch && c.x == d.x && c.y == d.y; });
    }
    std::vector<Vec3f> one(81);
    std::vector<Vec3f> other(81);
    for (std::size_t p = 0; p < a.count(); ++p)
    {
        a.sample(box.grid, values, p, one.data());
        b.sample(box.grid, values, p, other.data());
        different += a[p].texel != b[p].texel || one != other;
    }
    CHECK(different == 0);
    five.cancel_after(3);
    CHECK_THROWS_AS(Patches(box.surface, box.grid, box.upward, 9, 4, five), Canceled);
}
