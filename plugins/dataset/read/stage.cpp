#include <fresco/artifact.h>
#include <fresco/dataset/dataset_files.h>
#include <fresco/dataset/manifest.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

/// A dataset's files, checked as they are read: Error names one that is missing, not as listed, of another shape or type, or with
/// values out of range.
struct Source
{
    std::filesystem::path folder;
    dataset::Manifest manifest;

    std::string path(const std::string& name) const { return (folder / name).string(); }
    std::vector<std::byte> bytes(const std::string& name) const
    {
        return dataset::read_stamped(folder / name, manifest.files.at(name));
    }
    template <class T>
    Raster<T> raster(const std::string& name, int width, int height, int channels) const
    {
        return dataset::raster_from<T>(bytes(name), width, height, channels, path(name));
    }
    RasterF uv(const std::string& name, int width, int height) const
    {
        return manifest.uv == dataset::UvType::float32 ? raster<float>(name, width, height, 2)
                                                       : dataset::restored(raster<std::uint16_t>(name, width, height, 2));
    }
};

UvMap read_map(const Source& source, std::size_t view, std::size_t level)
{
    const dataset::View& entry = source.manifest.views[view];
    const int height = source.manifest.heights_px[level];
    const int width = entry.color.intrinsics.width_at(height);
    const auto name = [&](const char* quantity) { return dataset::map_name(view, quantity, height); };
    UvMap map;
    map.valid = source.raster<std::uint8_t>(name("valid"), width, height, 1);
    dataset::check_valid(map.valid, entry.valid_pixels[level], source.path(name("valid")));
    map.uv = source.uv(name("uv"), width, height);
    dataset::check_uv(map.uv, source.path(name("uv")));
    map.depth = source.raster<float>(name("depth"), width, height, 1);
    dataset::check_depth(map.depth, map.valid, source.path(name("depth")));
    map.cosine = source.raster<float>(name("cosine"), width, height, 1);
    dataset::check_cosine(map.cosine, source.path(name("cosine")));
    source.raster<std::uint8_t>(name("color"), width, height, 3);  // Only checked.
    return map;
}

/// Copies a view's uv maps, with texcoords as float32, one height at a time; returns the most bits of their texcoords.
int copy_maps(const Source& source, std::size_t view, const ArtifactFolder& uvmaps)
{
    int most_bits = 0;
    for (std::size_t level = 0; level < source.manifest.heights_px.size(); ++level)
    {
        const UvMap map = read_map(source, view, level);
        // A dataset that was made from stored maps gets the same steps again.
        const int uv_bits = uv_bits_of(map);
        UvMaps::write_map(uvmaps, view, source.manifest.heights_px[level], map, uv_bits);
        most_bits = std::max(most_bits, uv_bits);
    }
    return most_bits;
}

/// The frame of a view, whose pictures at full size are copied to `folder`.
Frame copy_frame(const Source& source, std::size_t view, const std::filesystem::path& folder)
{
    const dataset::View& entry = source.manifest.views[view];
    Frame frame;
    frame.sequence = entry.sequence;
    frame.name = entry.frame;
    frame.number = entry.number;
    frame.color = entry.color;
    frame.depth = entry.depth;
    const auto write = [&](const char* quantity, const auto& picture)
    {
        const auto file = folder / fmt::format("{}.{}.npy", view, quantity);
        write_file(file, dataset::to_npy(picture));
        return PictureFile{file, ""};
    };
    const Intrinsics& depth = entry.depth.intrinsics;
    const Intrinsics& color = entry.color.intrinsics;
    frame.color_picture = write("color", source.raster<std::uint8_t>(dataset::picture_name(view), color.width, color.height, 3));
    if (entry.depth_unit_m)
    {
        frame.depth_unit_m = *entry.depth_unit_m;
        frame.depth_picture =
            write("depth", source.raster<std::uint16_t>(dataset::sensor_depth_name(view), depth.width, depth.height, 1));
    }
    return frame;
}

class DatasetRead final : public Stage
{
    Output<UvMaps> uvmaps{this, "uvmaps", "The dataset's uv maps"};
    Output<Frames> frames{this, "frames", "The dataset's frames, with pictures as NPY files that need no codec"};
    Output<Image> style{this, "style", "The dataset's style picture; 0 x 0 if it has none"};
    Output<Mesh> mesh{this, "mesh", "The dataset's mesh, with texcoords"};
    Option<InputFolder> path{this, "path", required, "Folder of the dataset"};

    dataset::Manifest manifest(RunContext& run) const
    {
        const auto file = path->path / dataset::manifest_name;
        if (!std::filesystem::exists(file))
            throw MissingInput(path->path.string() + ": " + std::string(dataset::manifest_name) +
                               " is missing: not a dataset, or an incomplete copy");
        // It stamps all other files: whatever a result was made from is known by it alone.
        run.reads_file(file);
        return dataset::parse_manifest(read_text_file(file, std::size_t{1} << 30U), file.string());
    }

    static Mesh checked_mesh(const Source& source)
    {
        const std::string name(dataset::mesh_name);
        source.bytes(name);
        Mesh result = *Mesh::load({source.folder, {}});
        check_mesh(result, source.path(name));
        if (result.texcoords.empty())
            throw Error(source.path(name) + ": the mesh has no texcoords; write the dataset again from a mesh with an atlas");
        return result;
    }

    static Image style_picture(const Source& source, RunContext& run)
    {
        const std::string name(dataset::style_name);
        if (source.manifest.has_style)
            return Image(dataset::picture_from(source.bytes(name), source.path(name)));
        run.message("the dataset holds no style picture: give texture.optimize one, as {file: picture.npy}");
        return {};
    }

    void read_views(const Source& source, UvMaps maps, Vec3d offset_m, RunContext& run)
    {
        Frames read;
        read.offset_m = offset_m;
        read.frames.resize(source.manifest.views.size());
        std::vector<int> uv_bits(read.frames.size());
        parallel_for_each(read.frames.size(), "views", run,
                          [&, maps_to = uvmaps.folder(), frames_to = frames.folder().path](std::size_t i)
                          {
                              uv_bits[i] = copy_maps(source, i, maps_to);
                              read.frames[i] = copy_frame(source, i, frames_to);
                          });
        maps.uv_bits = std::ranges::max(uv_bits);
        maps.heights_px = source.manifest.heights_px;
        for (const dataset::View& view : source.manifest.views)
            maps.views.push_back({view.sequence, view.frame, view.color, view.valid_pixels});
        uvmaps = std::move(maps);
        frames = std::move(read);
    }

    /// Files that a later version of the writer may add are not read, but must be whole, too.
    static void check_others(const Source& source, const RunContext& run)
    {
        const auto needed = dataset::needed_files(source.manifest);
        const std::set<std::string> known(needed.begin(), needed.end());
        for (const auto& [name, stamp] : source.manifest.files)
            if (!known.contains(name))
            {
                run.check_canceled();
                source.bytes(name);
            }
    }

    void run(RunContext& run) override
    {
        const Source source{path->path, manifest(run)};
        check_others(source, run);
        Mesh atlas = checked_mesh(source);
        UvMaps maps;
        maps.atlas = atlas_id(atlas);
        maps.texture_px = atlas.texture_px;
        const Vec3d offset_m = atlas.offset_m;
        mesh = std::move(atlas);
        style = style_picture(source, run);
        read_views(source, std::move(maps), offset_m, run);
        run.report("views", source.manifest.views.size());
        run.report("heights_px", Value::List(source.manifest.heights_px.begin(), source.manifest.heights_px.end()));
        run.report("files", source.manifest.files.size());
    }
};
}  // namespace

FRESCO_STAGE("dataset.read", DatasetRead, "Reads and validates a dataset: uv maps, frames, style picture and mesh")
