#include "catch.h"
#include "samples.h"
#include "two_chart_wall.h"

#include <fresco/error.h>

#include <map>
#include <set>

using namespace samples;

namespace
{

/// A chart's cells, by their column and row.
struct Cells
{
    const SurfaceGrid& grid;
    const SurfaceGrid::Sheet& sheet;

    std::size_t number(int x, int y) const
    {
        return sheet.first_cell + static_cast<std::size_t>(y) * static_cast<std::size_t>(sheet.width) +
               static_cast<std::size_t>(x);
    }
    bool owned(int x, int y) const { return grid.owns(number(x, y)); }
};

std::map<std::uint32_t, std::size_t> texels_of_charts(const Prepared& wall)
{
    std::map<std::uint32_t, std::size_t> result;
    for (const auto& texel : wall.grid.texels())
        ++result[wall.surface.charts.of_face[texel.face]];
    return result;
}

}  // namespace

TEST_CASE("a surface has as many texels as its area holds")
{
    for (const double spacing : {2.5, 0.5, 0.1, 0.073, 0.037, 0.01})
    {
        CAPTURE(spacing);
        const Prepared wall(two_chart_wall(), spacing);
        const double along = 1 / spacing;
        for (const auto& [chart, count] : texels_of_charts(wall))
        {
            CAPTURE(chart);
            CHECK(static_cast<double>(count) >= std::max(1.0, std::pow(std::floor(along - 1e-4), 2)));
            CHECK(static_cast<double>(count) <= std::pow(std::ceil(along + 1e-4), 2));
        }
    }
    // Turned charts cut cells at their borders: as many are won as lost.
    for (const double turn : {0.3, 1.0, 2.2})
        CHECK(static_cast<double>(Prepared(turned_wall(turn, 4), 0.02).grid.texels().size()) == Approx(5000).epsilon(0.01));
}

TEST_CASE("a texel lies on the surface where its cell is in the atlas")
{
    for (const double spacing : {0.1, 0.037})
    {
        const Prepared wall(two_chart_wall(), spacing);
        double worst = 0;
        for (const auto& texel : wall.grid.texels())
        {
            const std::uint32_t chart = wall.surface.charts.of_face[texel.face];
            const SurfaceGrid::Sheet& sheet = wall.grid.sheet(chart);
            const auto cell = static_cast<int>(texel.cell - sheet.first_cell);
            const double along_u = (cell % sheet.width - 0.5) * spacing;
            const double along_v = (cell / sheet.width - 0.5) * spacing;
            // The right chart is turned by half a turn.
            const Vec3d expected = chart == 0 ? Vec3d{along_u, along_v, 0} : Vec3d{2 - along_u, 1 - along_v, 0};
            worst = std::max(worst, length(vec_cast<double>(texel.position) - expected));
        }
        CHECK(worst < 1e-5);
    }
}

TEST_CASE("each point of the surface belongs to one texel")
{
    for (const double turn : {0.0, 0.4})
    {
        const double spacing = 0.05;
        const Prepared wall(turned_wall(turn, 3), spacing);
        const auto& texels = wall.grid.texels();
        double nearest = 1;
        std::set<std::uint32_t> cells;
        std::size_t strangers = 0;
        for (std::size_t a = 0; a < texels.size(); ++a)
        {
            cells.insert(texels[a].cell);
            strangers += wall.grid.texel_at(texels[a].cell) != a || !wall.grid.owns(texels[a].cell);
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

TEST_CASE("cells outside of a chart have the nearest texel of its grid, and a margin lies around")
{
    for (const double turn : {0.0, 0.5, 1.2})
    {
        const Prepared wall(turned_wall(turn, 2), 0.06);
        for (std::uint32_t chart = 0; chart < wall.surface.charts.count; ++chart)
        {
            REQUIRE(wall.grid.has_sheet(chart));
            const Cells cells{wall.grid, wall.grid.sheet(chart)};
            std::size_t wrong = 0;
            for (int y = 0; y < cells.sheet.height; ++y)
                for (int x = 0; x < cells.sheet.width; ++x)
                {
                    const bool at_border = x == 0 || y == 0 || x + 1 == cells.sheet.width || y + 1 == cells.sheet.height;
                    wrong += at_border && cells.owned(x, y);
                    const std::uint32_t texel = wall.grid.texel_at(cells.number(x, y));
                    REQUIRE(texel < wall.grid.texels().size());
                    const auto own = static_cast<int>(wall.grid.texels()[texel].cell - cells.sheet.first_cell);
                    const int away = std::abs(own % cells.sheet.width - x) + std::abs(own / cells.sheet.width - y);
                    int least = away;
                    for (int j = 0; j < cells.sheet.height; ++j)
                        for (int i = 0; i < cells.sheet.width; ++i)
                            if (cells.owned(i, j))
                                least = std::min(least, std::abs(i - x) + std::abs(j - y));
                    wrong += away != least;
                }
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("charts smaller than a texel have one, charts without area none")
{
    Mesh mesh = two_chart_wall();
    const auto extra = [&](Vec3f across, Vec3f along, float uv_per_m)
    {
        const auto column = static_cast<float>(mesh.triangles.size() - 4) / 20;
        add(mesh, rectangle({5 + 10 * column, 0, 0}, across, along, {0.2F + column, 0.8F}, uv_per_m));
    };
    extra({0.001F, 0, 0}, {0, 0.001F, 0}, 0.3F);
    extra({0.001F, 0, 0}, {0, 0.5F, 0}, 0.3F);
    extra({0.013F, 0, 0}, {0, 0.013F, 0}, 0.3F);
    extra({0, 0, 0}, {0, 0, 0}, 0.3F);        // a point
    extra({0.1F, 0, 0}, {0, 0.1F, 0}, 0.0F);  // nowhere in the atlas
    const Prepared wall(mesh, 0.02);
    auto texels = texels_of_charts(wall);
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
    Mesh mesh = two_chart_wall();
    for (Vec3f& p : mesh.positions)
        p = p * 1000;
    const PaintedSurface millimeters(mesh, run);
    CHECK_THROWS_WITH(SurfaceGrid(millimeters, 0.004, run), Catch::Contains("more than four billion texels") &&
                                                                Catch::Contains("stroke_cm") && Catch::Contains("in meters"));
    Mesh long_wall;
    add(long_wall, rectangle({}, {700, 0, 0}, {0, 0.5F, 0}, {0.5F, 0.5F}, 0.001F));
    const PaintedSurface corridor(long_wall, run);
    CHECK_THROWS_WITH(SurfaceGrid(corridor, 0.01, run), Catch::Contains("700") && Catch::Contains("65535") &&
                                                            Catch::Contains("stroke_cm") && Catch::Contains("in meters"));
    run.cancel_after(1);
    CHECK_THROWS_AS(SurfaceGrid(corridor, 0.05, run), Canceled);
}
