#include "scene_calibration.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/recordings/recording_stage.h>
#include <fresco/run_context.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

constexpr std::string_view full_mesh = "_vh_clean.ply";
constexpr std::string_view reduced_mesh = "_vh_clean_2.ply";

std::vector<fs::path> files_ending(const fs::path& folder, std::string_view ending, fresco::RunContext& run)
{
    run.reads_folder(folder, "*" + std::string(ending));
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string().ends_with(ending))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// The scene's mesh in `path`. `kind` "full": *_vh_clean.ply, "reduced": *_vh_clean_2.ply, "auto": the full one if it is there,
/// else the reduced one, else none: empty. Throws MissingInput if another kind is missing, Error if there are several.
fs::path find_mesh(const fs::path& path, std::string_view kind, fresco::RunContext& run)
{
    auto files = kind == "reduced" ? std::vector<fs::path>{} : files_ending(path, full_mesh, run);
    if (files.empty() && kind != "full")
        files = files_ending(path, reduced_mesh, run);
    if (files.empty() && kind == "auto")
        return {};
    if (files.empty())
        throw fresco::MissingInput(path.string() + ": no mesh " + (kind == "full" ? "*_vh_clean.ply" : "*_vh_clean_2.ply") +
                                   "; put it there or set option \"mesh\"");
    if (files.size() > 1)
        throw fresco::Error(path.string() + ": several meshes, " + files[0].filename().string() + " and " +
                            files[1].filename().string() + "; choose one with option \"mesh\"");
    return files[0];
}

/// The text file of the scene's properties, `path`/<scene>.txt: the one named like the folder, else the only .txt file. Empty if
/// there is none.
fs::path find_properties(const fs::path& path, fresco::RunContext& run)
{
    const auto named = path / (fs::weakly_canonical(path).filename().string() + ".txt");
    if (fs::exists(named))
        return named;
    const auto files = files_ending(path, ".txt", run);
    return files.size() == 1 ? files[0] : fs::path{};
}

class ScanScannet final : public RecordingStage
{
  public:
    ScanScannet()
        : RecordingStage({.path = "Folder of the exported scene",
                          .frames = "The recorded views, each with a color and a depth camera",
                          .every = "Use every n-th view",
                          .folder = fresco::folder_with({"color", "depth", "pose"})})
    {
    }

  private:
    RecordedMesh mesh{this, "Mesh; empty: the scene's own, by mesh_kind", "The scanned surface"};
    fresco::Option<std::string> mesh_kind{this, "mesh_kind", "auto", fresco::one_of({"auto", "full", "reduced"}),
                                          "full: *_vh_clean.ply, reduced: *_vh_clean_2.ply, auto: full if it exists"};
    fresco::Option<bool> align_axes{this, "align_axes", false,
                                    "Turn the scene by its axisAlignment, so that walls follow the axes"};
    PixelCenterOption pixel_center{this, "integer"};
    fresco::Option<double> depth_unit_m = depth_unit_option(this);

    Recording list(fresco::RunContext& run) override
    {
        auto views = numbered_views({path() / "color", "", {".jpg", ".png"}}, {path() / "depth", "", {".png"}},
                                    {path() / "pose", "", {".txt"}}, run);
        for (auto& view : views)
        {
            view.sequence = "scene";
            view.name = std::to_string(view.number);
            view.depth_unit_m = *depth_unit_m;
        }
        calibration_ = scannet::read_scene_calibration(path(), find_properties(path(), run), run);
        if (*align_axes && !calibration_.aligned_from_world)
            throw fresco::Error(path().string() + ": the scene has no axisAlignment; set align_axes: false");
        read_surface(run);
        return {.views = std::move(views), .files = "color/N.jpg (or .png), depth/N.png and pose/N.txt"};
    }

    void read_surface(fresco::RunContext& run)
    {
        const auto file = mesh.given().empty() ? find_mesh(path(), *mesh_kind, run) : mesh.given().path;
        if (file.empty())
            return mesh.leave_out(path().string() + "/*_vh_clean.ply or *_vh_clean_2.ply, or set option \"mesh\"", run);
        run.reads_file(file);
        auto surface = fresco::read_mesh(file);
        check_mesh(surface, file.string());
        if (*align_axes)
            for (auto& position : surface.positions)
                position = fresco::vec_cast<float>(calibration_.aligned_from_world->point(fresco::vec_cast<double>(position)));
        mesh = std::move(surface);
        run.report("mesh", file.filename().string());
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        view.source = view.pose.string();
        if (cameras_.color.width == 0)
            cameras_ = {intrinsics_for(calibration_.color, *pixel_center, codec().header(view.color), view.color),
                        intrinsics_for(calibration_.depth, *pixel_center, codec().header(view.depth), view.depth),
                        calibration_.depth_from_color};
        const auto pose = tracked_pose(read_matrix_text(view.pose, 4, 4), view.source);
        if (!pose)
            return false;
        cameras_.place(view, *pose);
        if (*align_axes)
            for (auto* world_from_camera : {&view.world_from_camera, &view.depth_camera->world_from_camera})
                *world_from_camera = *calibration_.aligned_from_world * *world_from_camera;
        return true;
    }

    scannet::SceneCalibration calibration_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_STAGE("scan.scannet", ScanScannet, "Posed frames and mesh of an exported ScanNet scene")
