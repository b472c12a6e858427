#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/uv_maps.h>

#include "uv_map_caster.h"

#include <algorithm>
#include <string>
#include <vector>

using namespace fresco;

namespace
{
std::vector<int> sorted_heights(std::vector<int> heights)
{
    std::sort(heights.begin(), heights.end());
    if (heights.empty())
        throw Error("heights_px is empty: name at least one height, for example [256]");
    if (const auto twice = std::adjacent_find(heights.begin(), heights.end()); twice != heights.end())
        throw Error("heights_px names " + std::to_string(*twice) + " twice: name each height once");
    return heights;
}

class UvmapsRaycast final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "Triangle mesh with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The views; their colour cameras are used"};
    Output<UvMaps> uvmaps{this, "uvmaps", "Per pixel: texcoord, depth, cosine of the viewing angle, validity"};
    Option<std::vector<int>> heights_px{this, "heights_px", {256}, range(16, 4096), "Heights of the maps; widths follow"};

    Cost cost() const override
    {
        return {.seconds = "faces * 2e-6 + frames * heights_px_squares * (1.5e-7 / cores + 1.5e-7)",
                .memory_mb = "100 + faces * 0.0004 + heights_px_squares * 6e-5",
                .disk_mb = "frames * heights_px_squares * 2.4e-5",
                .frames = {},
                .faces = {},
                .height_squares = "heights_px_squares"};
    }

    void check_inputs() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: put an atlas.* stage before uvmaps.raycast");
        if (frames->frames.empty())
            throw Error("port 'frames' brings no frames: check the scan's path and the stages that drop frames");
        for (const Frame& frame : frames->frames)
            check_camera(frame.color, "the colour camera of " + frame.sequence + "/" + frame.name);
    }

    void run(RunContext& run) override
    {
        check_inputs();
        const std::vector<int> heights = sorted_heights(*heights_px);
        const UvMapCaster caster(*mesh);
        const std::size_t total = frames->frames.size() * heights.size();

        UvMaps result;
        result.heights_px = heights;
        PixelCounts all;
        std::vector<std::string> blind;
        for (std::size_t i = 0; i < frames->frames.size(); ++i)
        {
            const Frame& frame = frames->frames[i];
            UvMaps::View view{frame.sequence, frame.name, frame.color, {}};
            for (std::size_t level = 0; level < heights.size(); ++level)
            {
                run.check_cancelled();
                PixelCounts counts;
                UvMaps::write_map(uvmaps.folder(), i, heights[level], caster.cast(frame.color, heights[level], run, counts));
                view.valid_pixels.push_back(counts.valid);
                all += counts;
                run.progress(static_cast<double>(i * heights.size() + level + 1), static_cast<double>(total), "maps");
            }
            if (std::all_of(view.valid_pixels.begin(), view.valid_pixels.end(), [](auto pixels) { return pixels == 0; }))
                blind.push_back(frame.sequence + "/" + frame.name);
            result.views.push_back(std::move(view));
        }
        tell(run, all, blind);
        uvmaps = std::move(result);
    }

    void tell(RunContext& run, const PixelCounts& all, const std::vector<std::string>& blind) const
    {
        run.report("maps", frames->frames.size() * heights_px->size());
        run.report("valid_pixels", all.valid);
        run.report("back_face_pixels", all.back_face);
        run.report("too_near_pixels", all.too_near);
        run.report("empty_pixels", all.nothing);
        run.report("blind_frames", blind.size());
        if (!blind.empty())
            run.warning(
                std::to_string(blind.size()) + " of " + std::to_string(frames->frames.size()) +
                " frames see no front of the mesh, the first is " + blind.front() +
                (blind.size() == frames->frames.size()
                     ? ": are the mesh and the poses in the same world frame, are the faces counter-clockwise from outside?"
                     : ""));
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raycast", UvmapsRaycast, "Casts the colour cameras' rays against the mesh: uv, depth and angle per pixel")
FRESCO_LIBRARY("Embree", raycast::embree_version())
