#include "inputs.h"

#include "furnish.h"
#include "recording.h"
#include "scan_mesh.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bench
{
namespace
{

constexpr std::uint32_t seed = 1;
constexpr float noise_m = 0.003F;
/// So that the views together have seen most of the room.
constexpr int scanning_views = 32;

fresco::Vec3d box_center(const fresco::Mesh& mesh)
{
    fresco::Vec3f low = mesh.positions.front();
    fresco::Vec3f high = low;
    for (const auto& p : mesh.positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return fresco::vec_cast<double>((low + high) * 0.5F);
}

}  // namespace

GeometryInput synthetic_room(double edge_m, int views, fresco::Progress& progress)
{
    const auto edge = static_cast<float>(edge_m);
    const auto scene = room::furnish({4.5F, 3.6F, 2.6F}, seed);
    const room::Caster caster(scene);
    const room::LightMap light(caster, progress);
    const auto net = room::surface_net(scene, edge, progress);
    const auto whole = room::noisy_mesh(net, scene, light, edge, noise_m, seed, progress);
    room::SeenVertices seen(net.positions);
    const auto recorder = room::make_recorder(640, 480, 320, 240);
    GeometryInput input{"synthetic room", {}, {}};
    const auto path = room::camera_path(scene, scanning_views, seed);
    for (std::size_t i = 0; i < path.size(); ++i)
    {
        const fresco::Camera depth{recorder.depth, path[i]};
        seen.add_view(room::render_depth(caster, depth), depth);
        const auto every = static_cast<std::size_t>(std::max(scanning_views / views, 1));
        if (i % every == 0 && input.cameras.size() < static_cast<std::size_t>(views))
            input.cameras.push_back({recorder.color, path[i] * recorder.color_from_depth.inverse()});
    }
    auto parts = room::parts_of_faces(net, scene);
    input.mesh = room::seen_part(whole, seen, parts);
    return input;
}

GeometryInput mesh_file(const std::filesystem::path& file, int views)
{
    GeometryInput input{file.filename().string(), fresco::read_mesh(file), {}};
    const auto center = box_center(input.mesh);
    for (int i = 0; i < views; ++i)
    {
        const double turn = 2 * std::numbers::pi * i / views;
        fresco::Camera camera;
        camera.intrinsics = {640, 480, 520, 520, 320, 240};
        // Columns: right, down (-z) and forward in the world, whose z points up.
        camera.world_from_camera.rotation.m = {std::sin(turn), 0, std::cos(turn), -std::cos(turn), 0, std::sin(turn), 0, -1, 0};
        camera.world_from_camera.translation = center;
        input.cameras.push_back(camera);
    }
    return input;
}

GeometryInput scan_folder(const std::filesystem::path& folder, int views)
{
    GeometryInput input{folder.filename().string(), fresco::read_mesh(folder / "mesh.ply"), {}};
    std::vector<std::filesystem::path> poses;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "seq-01"))
        if (entry.path().string().ends_with(".pose.txt"))
            poses.push_back(entry.path());
    std::sort(poses.begin(), poses.end());
    if (poses.empty())
        throw fresco::MissingInput((folder / "seq-01").string() + ": no *.pose.txt is there");
    for (std::size_t i = 0; i < static_cast<std::size_t>(views); ++i)
        input.cameras.push_back(
            {{640, 480, 528, 528, 320, 240},
             fresco::recordings::read_rigid_transform(poses[i * poses.size() / static_cast<std::size_t>(views)])});
    return input;
}

}  // namespace bench
