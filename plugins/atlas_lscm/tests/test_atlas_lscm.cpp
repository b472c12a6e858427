#include "atlas_check.h"
#include "conformal.h"
#include "shapes.h"

#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <numeric>
#include <set>

using fresco::Mesh;
using namespace fresco::geometry;

namespace
{

/// A third of a cylinder of radius 1 and height 1.
Mesh bent_sheet(std::uint32_t n)
{
    auto mesh = shapes::grid(n, [](float, float) { return 0.0F; });
    for (auto& p : mesh.positions)
    {
        const float angle = (p.x - 0.5F) * 2.0F;
        p = {std::sin(angle), p.y, std::cos(angle)};
    }
    return mesh;
}

/// A flat square with two square holes.
Mesh holed_sheet()
{
    auto mesh = shapes::grid(9, [](float x, float y) { return 0.1F * x * y; });
    std::vector<fresco::Triangle> kept;
    for (const auto& t : mesh.triangles)
    {
        const auto c = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0F / 3);
        const auto in = [&](float low) { return c.x > low && c.x < low + 0.2F && c.y > low && c.y < low + 0.2F; };
        if (!in(0.2F) && !in(0.6F))
            kept.push_back(t);
    }
    mesh.triangles = kept;
    return mesh;
}

std::vector<std::uint32_t> all_faces(const Mesh& mesh)
{
    std::vector<std::uint32_t> faces(mesh.triangles.size());
    std::iota(faces.begin(), faces.end(), 0u);
    return faces;
}

/// Euler's number and the count of closed border lines: 1 and 1 for a disk.
std::pair<long, std::size_t> shape_of(const Disk& disk)
{
    Mesh mesh;
    for (const auto& p : disk.points)
        mesh.positions.push_back(fresco::vec_cast<float>(p));
    mesh.triangles = disk.triangles;
    const auto counts = count_surface(mesh);
    DisjointSets lines(disk.points.size());
    std::set<std::uint32_t> on_border;
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t low, std::uint32_t high, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() == 1)
                      {
                          lines.join(low, high);
                          on_border.insert({low, high});
                      }
                  });
    std::set<std::uint32_t> roots;
    for (const auto v : on_border)
        roots.insert(lines.find(v));
    return {static_cast<long>(counts.vertices) - static_cast<long>(counts.edges) + static_cast<long>(counts.faces), roots.size()};
}

std::shared_ptr<Mesh> atlas_of(const Mesh& mesh, const fresco::Value& options, fresco::testing::TestRun& run)
{
    const auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "atlas.lscm");
    fresco::testing::TemporaryFolder folder;
    fresco::testing::TestFactory factory;
    fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*made), options, {{"mesh", std::make_shared<Mesh>(mesh)}},
                               folder.path(), run, factory);
    return Mesh::load({folder.path() / "atlas", {}});
}

}  // namespace

TEST_CASE("a disk stays whole; holes are connected to the outline by cuts")
{
    const auto sheet = bent_sheet(6);
    const auto whole = cut_to_disk(Surface(sheet), all_faces(sheet));
    CHECK(whole.cut_edges == 0);
    CHECK(whole.points.size() == sheet.positions.size());
    CHECK(shape_of(whole) == std::pair<long, std::size_t>{1, 1});

    const auto holed = holed_sheet();
    const auto cut = cut_to_disk(Surface(holed), all_faces(holed));
    CHECK(cut.cut_edges >= 4);  // two edges from the outline to the first hole, two on to the second
    CHECK(cut.cut_edges <= 12);
    CHECK(shape_of(cut) == std::pair<long, std::size_t>{1, 1});

    // A torus: no border at all, two cuts that cross.
    Mesh torus;
    for (std::uint32_t i = 0; i < 8; ++i)
        for (std::uint32_t j = 0; j < 8; ++j)
        {
            const double u = 0.785398 * i;
            const double v = 0.785398 * j;
            torus.positions.push_back({static_cast<float>((2 + std::cos(v)) * std::cos(u)),
                                       static_cast<float>((2 + std::cos(v)) * std::sin(u)), static_cast<float>(std::sin(v))});
            const auto at = [](std::uint32_t a, std::uint32_t b) { return a % 8 * 8 + b % 8; };
            torus.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            torus.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    const auto opened = cut_to_disk(Surface(torus), all_faces(torus));
    CHECK(opened.cut_edges >= 16);
    CHECK(shape_of(opened) == std::pair<long, std::size_t>{1, 1});
}

TEST_CASE("a bent sheet unrolls without any stretch")
{
    const auto sheet = bent_sheet(12);
    const auto disk = cut_to_disk(Surface(sheet), all_faces(sheet));
    const auto places = conformal_map(disk);
    REQUIRE(places);
    for (const auto& t : disk.triangles)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = t[k];
            const auto b = t[(k + 1) % 3];
            CHECK(length((*places)[b] - (*places)[a]) == Approx(length(disk.points[b] - disk.points[a])).epsilon(1e-3));
        }
}

TEST_CASE("the stage: same ports and options, no overlap, less stretch than projection")
{
    fresco::testing::TestRun run;
    const auto sheet = bent_sheet(20);
    const auto atlas = atlas_of(sheet, fresco::Value::Map{{"size_px", 256}}, run);
    CHECK(check_atlas(*atlas, 256, 4).none());
    CHECK(run.reported.at("charts").as_int() == 1);
    CHECK(run.reported.at("conformal_charts").as_int() == 1);
    CHECK(run.reported.at("projected_charts").as_int() == 0);
    CHECK(run.reported.at("stretch_l2").as_double() == Approx(1).epsilon(1e-3));

    fresco::testing::TestRun ball;
    const auto round = atlas_of(shapes::sphere(24, 48), fresco::Value::Map{{"size_px", 512}}, ball);
    CHECK(check_atlas(*round, 512, 4).none());
    CHECK(ball.reported.at("conformal_charts").as_int() >= 4);
}

TEST_CASE("a noisy corner: charts that fold fall back, and threads do not matter")
{
    fresco::testing::TestRun run(2);
    const auto mesh = shapes::noisy_corner(30);
    const auto atlas = atlas_of(mesh, fresco::Value::Map{{"size_px", 512}}, run);
    CHECK(check_atlas(*atlas, 512, 4).none());
    CHECK(run.reported.at("conformal_charts").as_int() + run.reported.at("projected_charts").as_int() +
              run.reported.at("single_triangles").as_int() ==
          run.reported.at("charts").as_int());
    fresco::testing::TestRun one(1);
    CHECK(atlas_of(mesh, fresco::Value::Map{{"size_px", 512}}, one)->texcoords == atlas->texcoords);
}
