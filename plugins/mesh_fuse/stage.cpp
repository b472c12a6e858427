#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include "fusion.h"
#include "seen_colors.h"

#include <string>

using namespace fresco;

namespace
{
class MeshFuse final : public Stage
{
    Input<Frames> frames{this, "frames", "Recorded frames with depth pictures"};
    Output<Mesh> mesh{this, "mesh", "The surface that the depth pictures show, with vertex colors"};
    Option<double> voxel_m{this, "voxel_m", 0.02, range(0.001, 1), "Side of a voxel, and about that of a triangle"};
    Option<double> trunc_m{this, "trunc_m", 0, range(0, 10),
                           "Average distances up to this far from the surface; more than the depth noise; 0: four voxels"};
    Option<double> max_depth_m{this, "max_depth_m", 5, range(0.1, 1000), "Ignore depth beyond this; noise grows with distance"};
    Option<double> max_memory_gb{this, "max_memory_gb", 4, range(0.01, 10'000), "Stop with an error if the volume needs more"};
    Slot<ImageIo> images{this, "images", "image.opencv", optional, "Reads pictures that are not NPY; none: all are NPY"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 2, .per_frame = 0.15},
                .memory_mb = {.fixed = 150, .per_face = 7.5e-4},
                .disk_mb = {.per_face = 2.5e-5},
                .faces = {.number = 80, .divided_by = {"voxel_m", "voxel_m"}}};
    }

    const ImageIo* codec() const { return images.has_value() ? images.get().get() : nullptr; }

    FusionOptions options() const
    {
        const double truncation_m = *trunc_m > 0 ? *trunc_m : 4 * *voxel_m;
        if (truncation_m < *voxel_m)
            throw Error("option \"trunc_m\": " + std::to_string(*trunc_m) + " is less than voxel_m; expected at least " +
                        std::to_string(*voxel_m));
        return {.voxel_m = *voxel_m, .truncation_m = truncation_m};
    }

    /// Depth as it is to be fused: what is too far counts as none.
    RasterF near_depth(const Frame& frame) const
    {
        RasterF depth = load_depth(frame, codec());
        for (float& meters : depth.values)
            if (double{meters} > *max_depth_m)
                meters = 0;
        return depth;
    }

    void check_memory(const Fusion& fusion, const RasterF& depth, std::size_t index) const
    {
        constexpr double gigabyte = 1e9;
        if (!fusion.fits(depth, frames->frames[index].depth, static_cast<std::size_t>(*max_memory_gb * gigabyte)))
            throw Error("with " + std::to_string(index + 1) + " of " + std::to_string(frames->frames.size()) +
                        " frames, the volume needs more than max_memory_gb: raise max_memory_gb or voxel_m (memory falls with "
                        "its square), or lower max_depth_m");
    }

    void run(RunContext& run) override
    {
        Fusion fusion(options());
        std::size_t fused = 0;
        for (std::size_t i = 0; i < frames->frames.size(); ++i)
        {
            run.check_canceled();
            const Frame& frame = frames->frames[i];
            if (!frame.depth_picture.empty())
            {
                const RasterF depth = near_depth(frame);
                check_memory(fusion, depth, i);
                fusion.add(depth, seen_colors(depth, frame.depth, load_color(frame, codec()), frame.color), frame.depth);
                ++fused;
            }
            run.progress(static_cast<double>(i + 1), static_cast<double>(frames->frames.size()), "frames");
        }
        if (fused == 0)
            throw Error("no frame on port 'frames' has a depth picture: use a scan with depth");
        if (fused < frames->frames.size())
            run.warning(std::to_string(frames->frames.size() - fused) + " of " + std::to_string(frames->frames.size()) +
                        " frames have no depth picture and are left out");
        Mesh result = fusion.mesh();
        if (result.triangles.empty())
            throw Error(
                "the depth pictures show no surface: all depth is 0 or beyond max_depth_m; scan.inspect detects wrong units");
        check_mesh(result, "the fused mesh");
        run.report("frames", fused);
        run.report("faces", result.triangles.size());
        run.report("vertices", result.positions.size());
        run.report("volume_bytes", fusion.bytes());
        mesh = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("mesh.fuse", MeshFuse, "Fuses depth pictures into a mesh (truncated signed distances)")
FRESCO_LIBRARY("Open3D", open3d_version())
