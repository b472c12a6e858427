#include "catch.h"
#include "raw_images.h"
#include "splat_samples.h"
#include "surface_samples.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>

#include <cmath>

using namespace fresco;

namespace
{

/// A flat Gaussian on each face, 1 mm thick, as wide as the face.
splats::Splats flat_gaussians(const Mesh& mesh)
{
    splats::Splats splats;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto& [a, b, c] = mesh.triangles[f];
        const Vec3d area = geometry::area_vector(mesh, f) * 0.5;
        if (!(length(area) > 1e-8))
            continue;
        const Vec3d middle = vec_cast<double>(mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1 / 3.0);
        const Rgb8 color = mesh.colors[a];
        splats::samples::add_flat(
            splats, middle, normalized(area), 0.45 * std::sqrt(length(area)), 0.001, 0.95,
            Vec3f{static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])} * (1 / 255.0F));
    }
    return splats;
}

double quantile(const std::vector<double>& sorted, double share)
{
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

TEST_CASE("the generated room comes back from its splats within a centimeter", "[splats]")
{
    const testing::TemporaryFolder folder;
    const auto at = [&](const char* name) { return folder.path() / name; };
    const auto images = std::make_shared<testing::RawImages>();
    testing::TestRun run;
    testing::run_stage(
        SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room",
        Value::Map{{"frames_count", 24}, {"color_width_px", 64}, {"color_height_px", 48}, {"noise_m", 0.0}, {"edge_m", 0.04}}, {},
        at("room"), run, {{"image_io", images}});
    const auto room = Mesh::load({at("room") / "mesh", {}});
    write_file(at("room.ply"), splats::samples::ply(flat_gaussians(*room)));
    testing::run_stage(SCAN_SPLATS_PLUGIN, "scan.splats", Value::Map{{"path", at("room.ply").string()}}, {}, at("scan"), run,
                       {{"image_io", images}});
    CHECK(run.reported.at("inside").as_bool());
    const auto frames = Frames::load({at("scan") / "frames", {}});
    std::vector<RigidTransform> poses;
    for (const Frame& frame : frames->frames)
        poses.push_back(frame.color.world_from_camera);
    const auto up = cameras_up(poses);
    REQUIRE(up);
    CHECK(up->z > 0.999);
    testing::run_stage(MESH_FUSE_PLUGIN, "mesh.fuse", Value::Map{{"voxel_m", 0.0}, {"max_depth_m", 1000}, {"check_poses", false}},
                       {{"frames", frames}}, at("fused"), run, {{"image_io", images}});
    const auto fused = Mesh::load({at("fused") / "mesh", {}});
    const auto there = sampled_distances(*fused, *room), back = sampled_distances(*room, *fused);
    INFO("to the room " << quantile(there, 0.5) << ", " << quantile(there, 0.95) << "; back " << quantile(back, 0.5) << ", "
                        << quantile(back, 0.95));
    CHECK(quantile(there, 0.5) < 0.005);
    CHECK(quantile(there, 0.95) < 0.01);
    CHECK(quantile(back, 0.5) < 0.005);
    CHECK(quantile(back, 0.95) < 0.01);
}
