#include "masks.h"

#include <fresco/image_io.h>
#include <fresco/regions/regions.h>
#include <fresco/stage.h>

#include <algorithm>
#include <fmt/format.h>

FRESCO_LIBRARY("Embree", fresco::raycast::embree_version())

using namespace fresco;

namespace
{

class RegionsMasks final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The mesh to divide"};
    Input<Frames> frames{this, "frames", "The frames that the masks were drawn on"};
    Input<Regions> base{this, "regions", optional, "Regions of the same mesh for the faces that no mask has"};
    Output<Regions> regions{this, "regions", "The masked regions; all else is the region on port 'regions', or 'other'"};
    Option<InputFolder> path{this, "path", required,
                             "Masks, white inside: REGION/FRAME.png, of the size of the frame's color picture"};
    Option<double> least_share{this, "least_share", 0.5, range(0.01, 1),
                               "Share of a face's pixels that must be in a region's masks"};
    Slot<ImageIo> images{this, "Reads the masks"};

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (base.has_value())
            check_regions(*base, *mesh, "the regions on port 'regions'", "the mesh on port 'mesh'");
        run.reads_folder(path->path);
        const std::vector<MaskedRegion> found = find_masks(path->path, frames->frames);
        check_masks(found, run);
        const Votes votes = count(found, run);

        std::vector<std::string> names = base.has_value() ? base->names : std::vector<std::string>{};
        std::vector<std::uint32_t> label_of_region;
        for (const MaskedRegion& region : found)
        {
            const auto known = std::ranges::find(names, region.name);
            label_of_region.push_back(static_cast<std::uint32_t>(known - names.begin()));
            if (known == names.end())
                names.push_back(region.name);
        }
        const auto winners = votes.winners(*least_share);
        std::vector<std::uint32_t> labels(winners.size(), static_cast<std::uint32_t>(names.size()));
        std::size_t seen = 0;
        for (std::size_t face = 0; face < labels.size(); ++face)
        {
            seen += votes.is_seen(face) ? 1 : 0;
            if (winners[face] < found.size())
                labels[face] = label_of_region[winners[face]];
            else if (base.has_value())
                labels[face] = base->label_of_face[face];
        }
        Regions result = regions_from(*mesh, names, labels);
        for (const MaskedRegion& region : found)
            if (std::ranges::find(result.names, region.name) == result.names.end())
                throw Error((path->path / region.name).string() +
                            ": no mask marks any surface of the mesh; draw them white inside, on frames that show the region");
        run.report("seen_share", static_cast<double>(seen) / static_cast<double>(std::max<std::size_t>(labels.size(), 1)));
        report_regions(result, *mesh, run);
        regions = std::move(result);
    }

    /// All of them, before anything is cast.
    void check_masks(const std::vector<MaskedRegion>& found, RunContext& run) const
    {
        for (const MaskedRegion& region : found)
        {
            run.reads_folder(path->path / region.name);
            for (const auto& [number, file] : region.mask_of_frame)
            {
                run.reads_file(file);
                const Frame& frame = frames->frames[number];
                check_camera(frame.color, "the frame " + frame.name);
                const ImageHeader header = images->check(file);
                const Intrinsics& size = frame.color.intrinsics;
                if (header.width != size.width || header.height != size.height)
                    throw Error(
                        fmt::format("{}: {} x {} pixels, but the color picture of the frame has {} x {}: draw the mask at "
                                    "that size",
                                    file.string(), header.width, header.height, size.width, size.height));
            }
        }
    }

    Votes count(const std::vector<MaskedRegion>& found, RunContext& run) const
    {
        std::map<std::size_t, std::vector<std::pair<std::size_t, std::filesystem::path>>> by_frame;
        for (std::size_t region = 0; region < found.size(); ++region)
            for (const auto& [frame, file] : found[region].mask_of_frame)
                by_frame[frame].emplace_back(region, file);
        const raycast::Scene scene(*mesh);
        Votes votes(found.size(), mesh->triangles.size());
        std::size_t done = 0;
        for (const auto& [frame, masks] : by_frame)
        {
            const auto faces = faces_in_sight(scene, frames->frames[frame].color, run);
            for (const auto& [region, file] : masks)
            {
                const Raster8 mask = read_picture(*images, file);
                if (mask.channels == 4)
                    throw Error(file.string() +
                                ": the mask has transparent pixels; save it without transparency, white where the "
                                "region is and black elsewhere");
                votes.add(region, mask, faces);
            }
            run.progress(static_cast<double>(++done), static_cast<double>(by_frame.size()), "frames");
        }
        return votes;
    }
};

}  // namespace

FRESCO_STAGE("regions.masks", RegionsMasks, "Divides a mesh by masks drawn on some of its frames")
