#include "labeled_surface.h"
#include "masks.h"

#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/regions/regions.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/stage.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>

using namespace fresco;

namespace
{

/// A face farther than this from any labeled face takes no label: decimation and fusion move surfaces by less.
constexpr double within_m = 0.05;
/// If less of the mesh is so close, the labels are those of another mesh: holes that were closed take less.
constexpr double least_covered = 0.8;

class RegionsLabels final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The mesh to divide: the labeled one, or one made from it"};
    Input<Model> model{this, "model", optional, "A model whose materials have the regions' names, in place of files"};
    Input<Regions> objects{this, "objects", optional,
                           "Regions of the mesh on port 'labeled', such as a model's objects, in place of files"};
    Input<Mesh> labeled{this, "labeled", optional,
                        "The mesh that the labels are for; needed for objects, for JSON, and for a PLY that lies elsewhere"};
    Input<Frames> frames{this, "frames", optional, "The frames that the masks were drawn on"};
    Input<Regions> base{this, "regions", optional, "Regions of the same mesh for the faces that no label or mask has"};
    Output<Regions> regions{this, "regions", "The regions; faces without one are those of port 'regions', or 'other'"};
    Option<InputFile> path{
        this, "path", InputFile{}, formats({ply_format(), json_format()}),
        "Labels: a PLY such as ScanNet's .labels.ply, ScanNet's .aggregation.json or Matterport3D's .semseg.json"};
    Option<InputFile> segments{this, "segments", InputFile{}, formats({json_format()}),
                               "ScanNet's .segs.json or Matterport3D's .fsegs.json, for a 'path' that ends in .json"};
    Option<std::string> property{this, "property", "label",
                                 "Integer property of the PLY's vertices or faces that has the labels"};
    Option<std::string> naming{this, "naming", "nyu40", one_of({"nyu40", "numbers"}),
                               "Names of a PLY's labels: ScanNet's NYU40 classes, or the numbers themselves"};
    Option<InputFolder> masks{this, "masks", InputFolder{},
                              "Masks, white inside: REGION/FRAME.png, of the size of the frame's color picture"};
    Slot<ImageIo> images{this, optional, "Reads masks; none: only labels"};

    void run(RunContext& run) override
    {
        check();
        Regions result = masks->empty() ? from_labels(run) : from_masks(run);
        report_regions(result, *mesh, run);
        regions = std::move(result);
    }

    void check() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (!path->empty() + !masks->empty() + model.has_value() + objects.has_value() != 1)
            throw Error("set either 'path' to a file with labels, 'masks' to a folder of masks, or one of the inputs 'model' and "
                        "'objects'");
        if (!masks->empty() && !frames.has_value())
            throw Error("'masks' needs the frames that they were drawn on: wire them to the input 'frames'");
        if (!masks->empty())
            check_offset(*frames, *mesh);
        const bool is_json = path->path.extension() == ".json";
        if (is_json && (segments->empty() || !labeled.has_value()))
            throw Error(path->path.string() +
                        " labels the segments of a mesh: set 'segments' to the scene's .segs.json or .fsegs.json, and wire the "
                        "mesh that both are for to the input 'labeled'");
        if (!is_json && !segments->empty())
            throw Error("option \"segments\" is for a 'path' that ends in .json");
        if (objects.has_value() && !labeled.has_value())
            throw Error("wire the mesh that the objects are of to the input 'labeled'");
        if (labeled.has_value())
            check_mesh(*labeled, "the mesh on port 'labeled'");
        if (base.has_value())
            check_regions(*base, *mesh, "the regions on port 'regions'", "the mesh on port 'mesh'");
    }

    LabeledSurface surface() const
    {
        if (model.has_value())
        {
            check_model(*model, "the model on port 'model'");
            return surface_from_materials(*model);
        }
        if (objects.has_value())
        {
            check_regions(*objects, *labeled, "the regions on port 'objects'", "the mesh on port 'labeled'");
            return {*labeled, objects->names, {objects->label_of_face.begin(), objects->label_of_face.end()}};
        }
        if (path->path.extension() == ".json")
            return surface_from_segments(read_text_file(path->path), path->path.string(), read_text_file(segments->path),
                                         segments->path.string(), *labeled);
        return surface_from_ply(read_file(path->path), path->path.string(), *property,
                                *naming == "nyu40" ? Naming::nyu40 : Naming::numbers, labeled.has_value() ? &*labeled : nullptr);
    }

    Regions from_labels(RunContext& run) const
    {
        LabeledSurface from = surface();
        place(from.mesh, world_positions(from.mesh), mesh->offset_m);
        run.check_canceled();
        const CarriedLabels carried = carried_labels(from, *mesh, within_m, run);
        run.report("covered_share", carried.covered_share);
        run.report("mean_distance_m", carried.mean_distance_m);
        if (carried.covered_share < least_covered)
            throw Error(fmt::format("only {:.0f}% of the mesh on port 'mesh' is within {:g} cm of the labeled faces; expected at "
                                    "least {:.0f}%: these are labels of another mesh, or it was moved",
                                    100 * carried.covered_share, 100 * within_m, 100 * least_covered));
        std::vector<std::string> names = base_names();
        const std::vector<std::uint32_t> numbers = numbers_among(names, from.names);
        std::vector<std::uint32_t> labels;
        for (std::size_t face = 0; face < carried.label_of_face.size(); ++face)
        {
            const std::uint32_t label = carried.label_of_face[face];
            labels.push_back(label == no_label ? base_label(face) : numbers[label]);
        }
        return regions_from(*mesh, names, labels);
    }

    std::vector<std::string> base_names() const { return base.has_value() ? base->names : std::vector<std::string>{}; }

    std::uint32_t base_label(std::size_t face) const { return base.has_value() ? base->label_of_face[face] : no_label; }

    /// The numbers of names in a list, to which those that it lacks are added.
    static std::vector<std::uint32_t> numbers_among(std::vector<std::string>& names, const std::vector<std::string>& wanted)
    {
        std::vector<std::uint32_t> numbers;
        for (const std::string& name : wanted)
        {
            const auto known = std::ranges::find(names, name);
            numbers.push_back(static_cast<std::uint32_t>(known - names.begin()));
            if (known == names.end())
                names.push_back(name);
        }
        return numbers;
    }

    Regions from_masks(RunContext& run) const
    {
        run.reads_folder(masks->path);
        const std::vector<MaskedRegion> found = find_masks(masks->path, frames->frames);
        check_masks(found, run);
        const Votes votes = count(found, run);

        std::vector<std::string> names = base_names();
        std::vector<std::string> found_names;
        for (const MaskedRegion& region : found)
            found_names.push_back(region.name);
        const std::vector<std::uint32_t> label_of_region = numbers_among(names, found_names);
        const auto winners = votes.winners();
        std::vector<std::uint32_t> labels;
        std::size_t seen = 0;
        for (std::size_t face = 0; face < winners.size(); ++face)
        {
            seen += votes.is_seen(face) ? 1 : 0;
            labels.push_back(winners[face] < found.size() ? label_of_region[winners[face]] : base_label(face));
        }
        Regions result = regions_from(*mesh, names, labels);
        for (const MaskedRegion& region : found)
            if (std::ranges::find(result.names, region.name) == result.names.end())
                throw Error((masks->path / region.name).string() +
                            ": no mask marks any surface of the mesh; draw them white inside, on frames that show the region");
        run.report("seen_share", static_cast<double>(seen) / static_cast<double>(std::max<std::size_t>(labels.size(), 1)));
        return result;
    }

    /// Checks all masks before anything is rendered.
    void check_masks(const std::vector<MaskedRegion>& found, RunContext& run) const
    {
        for (const MaskedRegion& region : found)
        {
            run.reads_folder(masks->path / region.name);
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
        rendering::RasterFinder finder(*mesh);
        Votes votes(found.size(), mesh->triangles.size());
        std::size_t done = 0;
        for (const auto& [frame, files] : by_frame)
        {
            const FaceMap faces = faces_in_sight(*mesh, finder, frames->frames[frame].color, run);
            for (const auto& [region, file] : files)
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

FRESCO_STAGE(
    "regions.labels", RegionsLabels,
    "Divides a mesh by labels (of a PLY, of ScanNet's segmentation, a model's objects or materials) or by masks drawn on frames")
