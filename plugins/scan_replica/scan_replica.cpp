#include "replica_scene.h"

#include <fresco/component.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>

namespace
{

class ScanReplica final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the scene, with results and traj.txt in it"};
    fresco::Option<fresco::InputFile> mesh_file{
        this, "mesh", fresco::InputFile{}, "Mesh in the poses' world; empty: mesh.ply in path, or <scene>_mesh.ply beside it"};
    fresco::Option<fresco::InputFile> camera_file{this, "camera", fresco::InputFile{},
                                                  "Camera; empty: cam_params.json in path or beside it"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th frame"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The rendered views"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The scene's surface"};

    void run(fresco::RunContext& run) override
    {
        const auto& folder = path->path;
        const auto results = folder / "results";
        run.reads_folder(folder, "results");
        const auto pictures = replica::list_pictures(results);
        for (const char* names : {"frame*", "depth*.png"})
            run.reads_folder(results, names);
        const auto trajectory_file = folder / "traj.txt";
        run.reads_file(trajectory_file);
        const auto camera = find(*camera_file, replica::camera_candidates(folder), "the scene's camera", run);
        const auto surface = find(*mesh_file, replica::mesh_candidates(folder), "the scene's mesh", run);
        const auto views = replica::scene_views(
            pictures, replica::parse_trajectory(fresco::read_text_file(trajectory_file), trajectory_file.string()),
            trajectory_file, replica::parse_camera(fresco::read_text_file(camera), camera.string()), *every);
        mesh = fresco::read_mesh(surface);
        frames = fresco::recordings::registered_frames(views, *images, frames.folder().path, run);
        for (const auto& view : views)
        {
            run.reads_file(view.color);
            run.reads_file(view.depth);
        }
        run.report("frames", views.size());
        run.report("mesh", surface.filename().string());
        run.message(std::to_string(views.size()) + " frames");
    }

    /// The file that an option gives, else the first candidate; says what the result depends on.
    static std::filesystem::path find(const fresco::InputFile& given, const std::vector<std::filesystem::path>& candidates,
                                      std::string_view what, fresco::RunContext& run)
    {
        if (!given.empty())
            return given.path;
        for (const auto& candidate : candidates)
            run.reads_folder(candidate.parent_path(), candidate.filename().string());
        auto file = replica::first_file(candidates, what);
        run.reads_file(file);
        return file;
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.006, .per_face = 5e-7},
                .parallel_share = 0.5,
                .memory_mb = {.fixed = 20, .per_face = 1e-4},
                .disk_mb = {.per_face = 2.1e-5},
                .frames = {.files = "path", .pattern = "results/frame*", .divided_by = {"every"}},
                .faces = {.number = 1e6}};
    }
};

}  // namespace

FRESCO_STAGE("scan.replica", ScanReplica, "Rendered frames and mesh of a Replica scene, as NICE-SLAM lays them out")
