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

/// A dataset's folder, and the artifacts' folders that its views go to.
struct ViewFolders
{
    std::filesystem::path dataset;
    ArtifactFolder uvmaps;
    std::filesystem::path frames;
};

struct ReadView
{
    Frame frame;
    int uv_bits = 0;  ///< The most of its maps.
};

/// Reads the files of one dataset.
class Source
{
  public:
    Source(const dataset::Manifest& manifest, std::filesystem::path folder) : manifest_(manifest), folder_(std::move(folder)) {}

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    template <class T>
    Raster<T> raster(const std::string& name, int width, int height, int channels) const
    {
        const auto bytes = dataset::read_stamped(folder_ / name, manifest_.files.at(name));
        return dataset::raster_from<T>(bytes, width, height, channels, path(name));
    }
    RasterF uv(const std::string& name, int width, int height) const
    {
        return manifest_.uv == dataset::UvType::float32 ? raster<float>(name, width, height, 2)
                                                        : dataset::restored(raster<std::uint16_t>(name, width, height, 2));
    }

  private:
    const dataset::Manifest& manifest_;
    std::filesystem::path folder_;
};

UvMap read_map(const Source& source, const dataset::View& entry, std::size_t view, std::size_t level, int height)
{
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
    return map;
}

/// Copies one view: its uv maps to `uvmaps`, with texcoords as float32, and its pictures at full size to `frames`, whose frame is
/// returned. All files of the view are checked, those that are not copied too. Holds one height at a time. Thread-safe for
/// different views. Throws Error naming the file if it is missing, not as listed, of another shape or type, or holds values out
/// of range.
ReadView read_view(const dataset::Manifest& manifest, std::size_t view, const ViewFolders& folders)
{
    const Source source(manifest, folders.dataset);
    const dataset::View& entry = manifest.views[view];
    ReadView read;
    for (std::size_t level = 0; level < manifest.heights_px.size(); ++level)
    {
        const int height = manifest.heights_px[level];
        const UvMap map = read_map(source, entry, view, level, height);
        // Of a dataset that was made from stored maps, the same steps again.
        const int uv_bits = uv_bits_of(map);
        UvMaps::write_map(folders.uvmaps, view, height, map, uv_bits);
        read.uv_bits = std::max(read.uv_bits, uv_bits);
        source.raster<std::uint8_t>(dataset::map_name(view, "color", height), entry.color.intrinsics.width_at(height), height, 3);
    }

    Frame& frame = read.frame;
    frame.sequence = entry.sequence;
    frame.name = entry.frame;
    frame.number = entry.number;
    frame.color = entry.color;
    frame.depth = entry.depth;
    const auto write = [&](const char* quantity, const auto& picture)
    {
        const auto file = folders.frames / fmt::format("{}.{}.npy", view, quantity);
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
    return read;
}

class DatasetRead final : public Stage
{
    Output<UvMaps> uvmaps{this, "uvmaps", "The dataset's uv maps"};
    Output<Frames> frames{this, "frames", "The dataset's frames, with pictures as NPY files that need no codec"};
    Output<Image> style{this, "style", "The dataset's style picture; 0 x 0 if it has none"};
    Output<Mesh> mesh{this, "mesh", "The dataset's mesh, with texcoords"};
    Option<InputFolder> path{this, "path", required, folder_with({"dataset.json"}), "Folder of the dataset"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per = {{count::pixels, 1e-7}}},
                .memory_mb = {.fixed = 50, .per_core = 30, .per = {{count::faces, 2e-4}}},
                .disk_mb = {.per = {{count::faces, 5e-5}, {count::pixels, 2.5e-5}}},
                .makes = {{count::frames, {.files = "path", .pattern = "views/*/color.npy"}},
                          {count::faces, {.files = "path", .pattern = "mesh.ply", .bytes_each = 50}},
                          {count::pixels, {.files = "path", .pattern = "views/000000/depth_*.npy", .bytes_each = 4}}}};
    }

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

    std::vector<std::byte> listed(const dataset::Manifest& manifest, const std::string& name) const
    {
        return dataset::read_stamped(path->path / name, manifest.files.at(name));
    }

    Mesh checked_mesh(const dataset::Manifest& manifest) const
    {
        const auto file = path->path / dataset::mesh_name;
        listed(manifest, std::string(dataset::mesh_name));
        Mesh result = *Mesh::load({path->path, {}});
        check_mesh(result, file.string());
        if (result.texcoords.empty())
            throw Error(file.string() + ": the mesh has no texcoords; write the dataset again from a mesh with an atlas");
        return result;
    }

    Image style_picture(const dataset::Manifest& manifest, RunContext& run) const
    {
        if (manifest.has_style)
            return Image(dataset::picture_from(listed(manifest, std::string(dataset::style_name)),
                                               (path->path / dataset::style_name).string()));
        run.message("the dataset holds no style picture: give texture.optimize one, as {file: picture.npy}");
        return {};
    }

    void read_views(const dataset::Manifest& manifest, UvMaps maps, RunContext& run)
    {
        const ViewFolders folders{path->path, uvmaps.folder(), frames.folder().path};
        Frames read;
        read.frames.resize(manifest.views.size());
        std::vector<int> uv_bits(read.frames.size());
        parallel_for_each(read.frames.size(), "views", run,
                          [&](std::size_t i)
                          {
                              ReadView view = read_view(manifest, i, folders);
                              read.frames[i] = std::move(view.frame);
                              uv_bits[i] = view.uv_bits;
                          });
        maps.uv_bits = *std::ranges::max_element(uv_bits);
        maps.heights_px = manifest.heights_px;
        for (const dataset::View& view : manifest.views)
            maps.views.push_back({view.sequence, view.frame, view.color, view.valid_pixels});
        uvmaps = std::move(maps);
        frames = std::move(read);
    }

    /// What a later version of the writer may add is not read, but has to be whole as well.
    void check_others(const dataset::Manifest& manifest, const RunContext& run) const
    {
        const auto needed = dataset::needed_files(manifest);
        const std::set<std::string> known(needed.begin(), needed.end());
        for (const auto& [name, stamp] : manifest.files)
            if (!known.contains(name))
            {
                run.check_canceled();
                listed(manifest, name);
            }
    }

    void run(RunContext& run) override
    {
        const dataset::Manifest found = manifest(run);
        check_others(found, run);
        Mesh atlas = checked_mesh(found);
        UvMaps maps;
        maps.atlas = atlas_id(atlas);
        maps.texture_px = atlas.texture_px;
        mesh = std::move(atlas);
        style = style_picture(found, run);
        read_views(found, std::move(maps), run);
        run.report("views", found.views.size());
        run.report("heights_px", Value::List(found.heights_px.begin(), found.heights_px.end()));
        run.report("files", found.files.size());
    }
};
}  // namespace

FRESCO_STAGE("dataset.read", DatasetRead, "Reads and validates a dataset: uv maps, frames, style picture and mesh")
