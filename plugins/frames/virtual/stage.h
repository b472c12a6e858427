#pragma once

#include "free_space.h"
#include "view_plan.h"

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

/// \file The stage, for its plugin and for tests, which plan in rooms and grids smaller than any that is recorded.

namespace fresco::virtual_views
{

constexpr const char* virtual_sequence = "virtual";

inline std::string percent(double share)
{
    const auto hundredths = std::lround(std::floor(share * 10'000));
    return fmt::format("{}.{:02} %", hundredths / 100, hundredths % 100);
}

class FramesVirtual final : public Stage
{
  public:
    struct Fixed
    {
        double voxel_m = 0.2;      ///< Cameras may stand in the centers of such voxels: a few in every free square meter.
        double clearance_m = 0.5;  ///< Nearer to a surface, a texture's texels show as speckle.
        int cells_px = 1024;       ///< Cells along a side of the grid over the texture: centimeters in a room.
        int gap_px = 4;            ///< Texels that the coarse layers of a texture spread paint beyond what views see.
    };
    Fixed fixed;

  private:
    Input<Mesh> mesh{this, "mesh", "The room, with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The recorded frames; their color cameras and masks are used"};
    Output<Frames> result{this, "frames", "The recorded frames, then the virtual ones, which have no pictures"};
    Option<double> target_coverage{
        this, "target_coverage", 0.9, range(0.01, 1),
        "Stop when this share is painted of the surface that free space reaches and recorded frames do not paint"};
    Option<int> max_frames{this, "max_frames", 0, range(0, 100'000),
                           "Maximum number of virtual frames; 0: as many as the target needs"};
    /// Value of seeing a cell straight on, added to 1 for seeing it at all.
    static constexpr double angle_weight = 1;
    /// Value of seeing a cell from the recorded frames' median distance, as painters of the room do.
    static constexpr double distance_weight = 1;

    void run(RunContext& run) override
    {
        check_uv_mapping_inputs(*mesh, *frames);
        std::vector<Vec3d> eyes;
        for (const Frame& frame : frames->frames)
        {
            if (frame.sequence == virtual_sequence)
                throw Error(fmt::format("port 'frames' already has a virtual frame ({}/{}): wire the recorded frames",
                                        frame.sequence, frame.name));
            eyes.push_back(frame.color.world_from_camera.translation);
        }
        const VoxelGrid grid(*mesh, eyes, {.voxel_m = fixed.voxel_m, .clearance_m = fixed.clearance_m});

        const raycast::Scene scene(*mesh);
        const auto places = free_space(scene, grid, eyes, fixed.clearance_m, run);
        if (places.empty())
            throw Error(fmt::format(
                "no free space: a virtual camera stands at the center of a voxel of {:g} m, {:g} m from all surfaces, with a "
                "free "
                "way to one of the {} recorded cameras, and there is no such place: check with scan.inspect that mesh and poses "
                "share one world frame",
                fixed.voxel_m, fixed.clearance_m, eyes.size()));
        const auto points = surface_points(*mesh, fixed.cells_px, run);
        Coverage coverage(scene, points, fixed.cells_px, gap_cells());
        const double distance_m = add_frames(coverage, *frames, run);
        if (distance_m == 0)
            throw Error(
                fmt::format("none of the {} frames sees the front of the mesh: check with scan.inspect that mesh and poses "
                            "share one world frame and that faces are counter-clockwise from outside",
                            eyes.size()));
        auto wanted = coverage.unpainted();
        const std::size_t unrecorded = wanted.size();
        const auto witness_of = witnesses(scene, points, places, wanted, run);
        std::erase_if(wanted, [&](std::uint32_t point) { return witness_of[point] == nobody; });
        const auto plan = plan_views(coverage, places, wanted, witness_of, rules(distance_m, wanted.size(), run), run);
        report({.points = points.size(), .unrecorded = unrecorded, .wanted = wanted.size(), .places = places.size()}, plan, run);
        result = listed(plan);
    }

    int gap_cells() const { return mesh->texture_px > 0 ? fixed.gap_px * fixed.cells_px / mesh->texture_px : 0; }

    PlanRules rules(double distance_m, std::size_t wanted, RunContext& run) const
    {
        std::vector<RigidTransform> poses;
        for (const Frame& frame : frames->frames)
            poses.push_back(frame.color.world_from_camera);
        const geometry::Upward up = geometry::find_up(*mesh, cameras_up(poses));
        if (up.from == geometry::UpEvidence::nothing)
            run.warning("neither the cameras nor the mesh clearly shows which way is up, so the file's axis is used: virtual "
                        "pictures may be tilted");
        return {.intrinsics = frames->frames.front().color.intrinsics,
                .upright = upright_of(*frames, up.direction),
                .distance_m = distance_m,
                .angle_weight = angle_weight,
                .distance_weight = distance_weight,
                .most_unpainted = static_cast<std::size_t>((1 - *target_coverage) * static_cast<double>(wanted)),
                .most_views = *max_frames == 0 ? std::numeric_limits<std::size_t>::max() : static_cast<std::size_t>(*max_frames)};
    }

    Frames listed(const ViewPlan& plan) const
    {
        Frames all;
        all.frames = frames->frames;
        for (std::size_t i = 0; i < plan.cameras.size(); ++i)
        {
            Frame frame;
            frame.sequence = virtual_sequence;
            frame.name = fmt::format("view-{:06}", i);
            frame.number = static_cast<long>(i);
            frame.color = plan.cameras[i];
            frame.depth = frame.color;
            all.frames.push_back(frame);
        }
        return all;
    }

    struct Counts
    {
        std::size_t points;
        std::size_t unrecorded;  ///< Points that no recorded frame sees; …
        std::size_t wanted;      ///< … those of them that free space reaches.
        std::size_t places;
    };

    void report(const Counts& counts, const ViewPlan& plan, RunContext& run) const
    {
        const std::size_t recorded = counts.points - counts.unrecorded;
        const std::size_t reached = recorded + counts.wanted;
        const auto share = [](std::size_t part, std::size_t whole)
        { return static_cast<double>(part) / static_cast<double>(whole); };
        const double recorded_share = share(recorded, reached);
        const double all_share = share(reached - plan.unpainted.size(), reached);
        run.report("recorded_frames", frames->frames.size());
        run.report("virtual_frames", plan.cameras.size());
        run.report("free_voxels", counts.places);
        run.report("cells", counts.points);
        run.report("reachable_share", share(reached, counts.points));
        run.report("coverage_recorded", recorded_share);
        run.report("coverage", all_share);
        run.message(fmt::format("{} recorded frames paint {} of the surface that free space reaches; with {} virtual ones {}",
                                frames->frames.size(), percent(recorded_share), plan.cameras.size(), percent(all_share)));
    }
};

}  // namespace fresco::virtual_views
