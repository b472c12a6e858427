#include "scene_frames.h"

#include <fresco/image_io.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>

namespace
{

class ScanScannet final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the exported scene, with color, depth, pose and the mesh in it"};
    fresco::Option<fresco::InputFile> mesh_file{this, "mesh", fresco::InputFile{}, "Mesh; empty: the scene's own, by mesh_kind"};
    fresco::Option<std::string> mesh_kind{this, "mesh_kind", "auto", fresco::one_of({"auto", "full", "reduced"}),
                                          "full: *_vh_clean.ply, reduced: *_vh_clean_2.ply, auto: the full one where it is"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th view"};
    fresco::Option<bool> align_axes{this, "align_axes", false,
                                    "Turn the scene by its axisAlignment, so that walls follow the axes"};
    fresco::Option<std::string> pixel_center{
        this, "pixel_center", "integer", fresco::one_of({"half", "integer"}),
        "Where the intrinsics put the center of the first pixel: at (0.5, 0.5) or at (0, 0)"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.001, fresco::range(1e-6, 1.0),
                                        "Meters per step of the depth pictures"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The recorded views, color and depth camera each"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The scanned surface"};

    void run(fresco::RunContext& run) override
    {
        const auto& folder = path->path;
        const auto views = scannet::list_views(folder, *every);
        const auto properties = scannet::find_properties(folder);
        const auto calibration = scannet::read_scene_calibration(folder, properties);
        if (*align_axes && !calibration.aligned_from_world)
            throw fresco::Error(folder.string() + ": the scene has no axisAlignment; leave align_axes out");
        const auto surface_file = mesh_file->empty() ? scannet::find_mesh(folder, *mesh_kind) : mesh_file->path;
        record_names(properties, surface_file, run);
        record_files(views, calibration, surface_file, run);

        auto surface = fresco::read_mesh(surface_file);
        const auto center = *pixel_center == "half" ? fresco::PixelCenter::half : fresco::PixelCenter::integer;
        auto scene = scannet::scene_frames(views, calibration, center, *images, run);
        for (auto& frame : scene.frames.frames)
            frame.depth_unit_m = *depth_unit_m;
        if (*align_axes)
            scannet::transform_scene(*calibration.aligned_from_world, scene.frames, surface);

        run.report("frames", scene.frames.frames.size());
        run.report("poses_not_tracked", scene.not_tracked);
        run.report("mesh", surface_file.filename().string());
        run.message(std::to_string(scene.frames.frames.size()) + " frames, " + std::to_string(scene.not_tracked) +
                    " left out because their pose is not finite");
        frames = std::move(scene.frames);
        mesh = std::move(surface);
    }

    void record_names(const std::filesystem::path& properties, const std::filesystem::path& surface_file,
                      fresco::RunContext& run) const
    {
        const auto& folder = path->path;
        for (const char* names : {"color/*.jpg", "color/*.png", "depth/*.png", "pose/*.txt", "intrinsic/*.txt"})
            if (const auto pattern = folder / names; std::filesystem::exists(pattern.parent_path()))
                run.reads_folder(pattern.parent_path(), pattern.filename().string());
        run.reads_folder(folder, "intrinsic");
        run.reads_folder(folder, scannet::properties_names(folder, properties));
        if (mesh_file->empty())
            for (const auto& names : scannet::mesh_names(surface_file, *mesh_kind))
                run.reads_folder(folder, names);
    }

    void record_files(const std::vector<fresco::ViewFiles>& views, const scannet::SceneCalibration& calibration,
                      const std::filesystem::path& surface_file, fresco::RunContext& run) const
    {
        for (const auto& file : calibration.files)
            run.reads_file(file);
        for (const auto& view : views)
            for (const auto& file : {view.color, view.depth, view.pose})
                run.reads_file(file);
        run.reads_file(surface_file);
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.006, .per_face = 5e-7},
                .parallel_share = 0.5,
                .memory_mb = {.fixed = 20, .per_face = 1e-4},
                .disk_mb = {.per_face = 2.1e-5},
                .frames = {.files = "path", .pattern = "pose/*.txt", .divided_by = {"every"}},
                .faces = {.files = "path", .pattern = "*_vh_clean*.ply", .bytes_each = 21}};
    }
};

}  // namespace

FRESCO_STAGE("scan.scannet", ScanScannet, "Posed frames and mesh of an exported ScanNet scene")
