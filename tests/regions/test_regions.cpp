#include "catch.h"
#include "raw_images.h"

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/regions/regions.h>
#include <fresco/testing.h>

#include <map>

using namespace fresco;

namespace
{

/// Intersection over union of each part's area. Both have the same names.
std::map<std::string, double> overlaps(const Mesh& mesh, const Regions& found, const Regions& truth)
{
    std::map<std::string, std::pair<double, double>> areas;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto& [a, b, c] = mesh.triangles[f];
        const double area = length(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
        const std::string& here = found.names[found.label_of_face[f]];
        const std::string& there = truth.names[truth.label_of_face[f]];
        areas[here].first += here == there ? area : 0;
        areas[here].second += area;
        areas[there].second += here == there ? 0 : area;
    }
    std::map<std::string, double> result;
    for (const auto& [name, both] : areas)
        result[name] = both.first / both.second;
    return result;
}

}  // namespace

TEST_CASE("regions.planes: floor, ceiling and walls of generated rooms")
{
    struct Room
    {
        int seed;
        double length_m, width_m, height_m, edge_m;
    };
    for (const Room& room : {Room{1, 4.5, 3.6, 2.6, 0.03}, Room{2, 7, 5, 3, 0.05}})
    {
        testing::TestRun run;
        const testing::TemporaryFolder scan;
        testing::run_stage(SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room",
                           Value::Map{{"seed", room.seed},
                                      {"size_m", Value::List{room.length_m, room.width_m, room.height_m}},
                                      {"edge_m", room.edge_m},
                                      {"frames_count", 24},
                                      {"color_width_px", 16},
                                      {"color_height_px", 16},
                                      {"depth_px", Value::List{160, 120}}},
                           {}, scan.path(), run, {{"image_io", std::make_shared<testing::RawImages>()}});
        const std::shared_ptr<const Mesh> mesh = Mesh::load({scan.path() / "mesh", scan.path()});
        const auto truth = Regions::load({scan.path() / "regions", scan.path()});
        check_regions(*truth, *mesh, "the truth", "the scan");
        const testing::TemporaryFolder out;
        testing::run_stage(REGIONS_PLANES_PLUGIN, "regions.planes", Value::Map{}, {{"mesh", mesh}}, out.path(), run);
        const auto found = Regions::load({out.path() / "regions", out.path()});
        auto overlap = overlaps(*mesh, *found, *truth);
        INFO("seed " << room.seed << ": floor " << overlap["floor"] << ", ceiling " << overlap["ceiling"] << ", walls "
                     << overlap["walls"] << ", furniture " << overlap["furniture"]);
        for (const char* part : {"floor", "ceiling", "walls"})
        {
            INFO(part);
            CHECK(overlap[part] >= 0.95);
        }
        CHECK(overlap["furniture"] >= 0.9);
    }
}
