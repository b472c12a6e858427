#include "alignment.h"

#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/stage.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

/// Height at which the mesh is drawn, to see which points a view shows.
constexpr int depth_height = 240;

/// Depth of the mesh's front, meters; 0: none.
RasterF drawn_depth(const Mesh& mesh, rendering::RasterFinder finder, const Camera& camera)
{
    FaceMap faces(camera.intrinsics.width, camera.intrinsics.height);
    finder.find({&camera, 1}, Progress(), {&faces, 1});
    const IntoCamera into_camera(camera.world_from_camera);
    const Camera own{camera.intrinsics, {}};
    RasterF depth(faces.width, faces.height);
    std::uint32_t last = no_face;
    Vec3d normal;
    double offset = 0;
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (const std::uint32_t face = faces.at(x, y); face != no_face)
            {
                const auto corner = [&](std::size_t i) { return into_camera.point(mesh.positions[mesh.triangles[face][i]]); };
                if (face != std::exchange(last, face))
                {
                    normal = cross(corner(1) - corner(0), corner(2) - corner(0));
                    offset = dot(normal, corner(0));
                }
                const double toward = dot(normal, own.ray(x + 0.5, y + 0.5));
                const double at = offset / toward;
                if (sight(toward < 0, at) == Sight::surface)
                    depth.at(x, y) = static_cast<float>(at);
            }
    return depth;
}

class FramesAlign final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room, in the world frame of the poses"};
    Input<Frames> frames{this, "frames", "Recorded frames"};
    Output<Frames> aligned{this, "frames", "The same frames with corrected poses of the color cameras"};
    Output<Table> agreement{this, "agreement", "How well the pictures agree on the surface: a row of the reported figures"};
    Option<int> points_count{this, "points_count", 60'000, range(100, 10'000'000),
                             "Maximum number of surface points at which views are compared"};
    Option<int> rounds_count{this, "rounds_count", 40, range(1, 10'000),
                             "Maximum number of steps at each of the three picture sizes"};
    /// Typical error of a camera's direction in tracked recordings: a prior, not a limit.
    static constexpr double likely_turn_deg = 1;
    /// Typical error of its position.
    static constexpr double likely_shift_m = 0.02;
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY; none: all are NPY"};

    align::AlignedView view_of(const Frame& frame, const std::vector<align::SurfacePoint>& points,
                               const rendering::RasterFinder& finder) const
    {
        check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
        const Camera camera{frame.color.intrinsics.scaled_to(frame.color.intrinsics.width_at(depth_height), depth_height),
                            frame.color.world_from_camera};
        RasterF depth = drawn_depth(*mesh, finder, camera);
        const Raster8 mask = mask_at(load_mask(frame), depth.width, depth.height);
        for (std::size_t i = 0; i < mask.values.size(); ++i)
            if (mask.values[i] == 0)
                depth.values[i] = 0;
        return {frame.color.intrinsics, align::sightings(points, camera, depth),
                align::brightness_levels(load_color(frame, images.has_value() ? images.get().get() : nullptr))};
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        check_offset(*frames, *mesh);
        const auto& all = frames->frames;
        if (all.empty())
            throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
        const auto points = align::surface_points(*mesh, static_cast<std::size_t>(*points_count));
        const rendering::RasterFinder finder(*mesh);
        std::vector<align::AlignedView> views(all.size());
        parallel_for_each(all.size(), "frames", run, [&](std::size_t i) { views[i] = view_of(all[i], points, finder); });
        const auto found = align::align(views, points.size(),
                                        {.rounds_count = *rounds_count,
                                         .likely_turn = likely_turn_deg * std::numbers::pi / 180,
                                         .likely_shift_m = likely_shift_m},
                                        run);
        Frames result = *frames;
        for (std::size_t i = 0; i < all.size(); ++i)
            result.frames[i].color.world_from_camera =
                all[i].color.world_from_camera * found.corrected_from_recorded[i].inverse();
        tell(found, points.size(), views, run);
        aligned = std::move(result);
    }

    void tell(const align::Alignment& found, std::size_t points, const std::vector<align::AlignedView>& views, RunContext& run)
    {
        const double usual = numerics::median(found.moved_px);
        const double most = std::ranges::max(found.moved_px);
        std::size_t sightings = 0;
        std::size_t blind = 0;
        for (const auto& view : views)
        {
            sightings += view.sightings.size();
            blind += view.sightings.empty();
        }
        run.report("points", points);
        run.report("sightings", sightings);
        run.report("blind_frames", blind);
        Table table;
        table.columns = {"error_before", "error_after", "median_moved_px", "most_moved_px"};
        table.rows = {{found.error_before, found.error_after, usual, most}};
        run.report("median_moved_px", usual);
        run.report("most_moved_px", most);
        run.report("error_before", found.error_before);
        run.report("error_after", found.error_after);
        agreement = std::move(table);
        if (found.error_before > 0)
            run.message(fmt::format("pictures moved by {} px (median), {} px at most; they differ by {} % less",
                                    std::lround(usual), std::lround(most),
                                    std::lround(100 * (1 - found.error_after / found.error_before))));
        if (blind > 0)
            run.warning(fmt::format("{} of {} frames see no point of the mesh and stay as they are{}", blind, views.size(),
                                    blind == views.size() ? ": are the mesh and the poses in the same world frame?" : ""));
    }
};

}  // namespace

FRESCO_STAGE("frames.align", FramesAlign, "Corrects the poses of the color cameras so that their pictures agree on the surface")
