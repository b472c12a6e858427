#include "posed_frames.h"

#include <fresco/component.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>

namespace
{

class ScanSevenScenes final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required, "Folder of the scan, with seq-01, seq-02, … in it"};
    fresco::Option<fresco::InputFile> mesh_file{this, "mesh", fresco::InputFile{},
                                                "Mesh in the poses' world; empty: mesh.ply in path"};
    fresco::Option<std::vector<int>> sequences{this, "sequences", std::vector<int>{}, fresco::range(0, 999'999),
                                               "Numbers of the sequences to take; empty: all"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th frame of each sequence"};
    fresco::Option<std::vector<double>> color_k{
        this, "color_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the color camera in pixels; empty: color-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> depth_k{
        this, "depth_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the depth camera in pixels; empty: depth-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> color_from_depth{
        this, "color_from_depth", std::vector<double>{},
        "16 numbers, row by row, X_color = M X_depth in meters; empty: color_from_depth.txt in path"};
    fresco::Option<std::string> pixel_center{
        this, "pixel_center", "half", fresco::one_of({"half", "integer"}),
        "Where the intrinsics put the center of the first pixel: at (0.5, 0.5) or at (0, 0)"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.001, fresco::range(1e-6, 1.0),
                                        "Meters per step of the depth pictures"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The recorded views, color and depth camera each"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The scanned surface"};

    void run(fresco::RunContext& run) override
    {
        const auto& folder = path->path;
        const auto scan = list_scan(folder, *sequences, *every);
        const auto calibration =
            read_calibration(folder, {*color_k, *depth_k, *color_from_depth,
                                      *pixel_center == "half" ? fresco::PixelCenter::half : fresco::PixelCenter::integer});
        record_inputs(scan, calibration, run);
        for (const auto& guess : calibration.guesses)
            run.warning(guess);

        mesh = read_scan_mesh(run);
        auto posed = posed_frames(scan, calibration, *images, run);
        for (auto& frame : posed.frames)
            frame.depth_unit_m = *depth_unit_m;
        run.report("frames", posed.frames.size());
        run.report("sequences", scan.sequences.size());
        run.message(std::to_string(posed.frames.size()) + " frames of " + std::to_string(scan.sequences.size()) + " sequences");
        frames = std::move(posed);
    }

    fresco::Mesh read_scan_mesh(fresco::RunContext& run) const
    {
        const auto file = mesh_file->empty() ? path->path / "mesh.ply" : mesh_file->path;
        if (!std::filesystem::exists(file))
            throw fresco::MissingInput(file.string() + ": no mesh; put the scan's mesh there or give the option mesh");
        run.reads_file(file);
        return fresco::read_mesh(file);
    }

    void record_inputs(const ScanFolder& scan, const Calibration& calibration, fresco::RunContext& run) const
    {
        run.reads_folder(path->path, "seq-*");
        for (const auto& sequence : scan.sequences)
            run.reads_folder(sequence, "frame-*");
        for (const auto& name : calibration.missing)
            run.reads_folder(path->path, name);
        for (const auto& file : calibration.files)
            run.reads_file(file);
        for (const auto& frame : scan.frames)
            for (const auto& file : {frame.color, frame.depth, frame.pose})
                run.reads_file(file);
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per_frame = 0.001, .per_face = 5e-7},
                .memory_mb = {.fixed = 20, .per_face = 1e-4},
                .disk_mb = {.per_face = 2.1e-5},
                .frames = {.files = "path", .pattern = "seq-*/frame-*.pose.txt", .divided_by = {"every"}},
                .faces = {.files = "path", .pattern = "mesh.ply", .bytes_each = 21}};
    }
};

}  // namespace

FRESCO_STAGE("scan.seven_scenes", ScanSevenScenes, "Posed frames and mesh in the layout of 7-Scenes")
