#include "view_writer.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/mesh_io.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>

#include <atomic>

using namespace fresco;

namespace
{
class DatasetWrite final : public Stage
{
    Input<UvMaps> uvmaps{this, "uvmaps", "The uv maps of the views to write"};
    Input<Frames> frames{this, "frames", "The frames that the uv maps were made from, with their pictures"};
    Input<Mesh> mesh{this, "mesh", "The mesh that the uv maps show, with texcoords"};
    Input<Image> style{this, "style", optional, "The style picture"};
    Output<Files> files{this, "files", "The dataset's folder: dataset.json and what it lists"};
    Option<OutputName> path{this, "path", OutputName{"dataset"}, "Folder to write, below --out"};
    Option<std::string> uv{this, "uv", "float32", one_of({"float32", "uint16"}),
                           "How texcoords are stored: as they are, or as round(65535 u), in half the space"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Reads the frames' pictures"};

    Cost cost() const override
    {
        return {.seconds = "1 + frames * (0.02 + height_squares * 1.5e-7) / cores",
                .memory_mb = "50 + faces * 0.0003 + cores * (10 + height_squares * 1.5e-5)",
                .disk_mb = "5 + faces * 5e-5 + frames * (2 + height_squares * 2.7e-5)",
                .frames = {},
                .faces = {}};
    }

    void check_inputs() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: give the one that the uv maps were made from");
        if (uvmaps->views.empty() || uvmaps->heights_px.empty())
            throw Error("port 'uvmaps' brings no uv maps");
    }

    /// Every view, its files below `folder`, in the uv maps' order.
    void write_views(const std::filesystem::path& folder, dataset::Manifest& manifest, RunContext& run) const
    {
        const auto frame_of = checked_frames(*uvmaps, *frames);
        std::vector<WrittenView> written(frame_of.size());
        std::atomic<std::size_t> done{0};
        parallel_for(written.size(), 1, run.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (std::size_t i = begin; i < end; ++i)
                         {
                             run.check_cancelled();
                             written[i] =
                                 write_view(folder, *uvmaps, i, frames->frames[frame_of[i]], images.get().get(), manifest.uv);
                             run.progress(static_cast<double>(++done), static_cast<double>(written.size()), "views");
                         }
                     });
        for (WrittenView& view : written)
        {
            manifest.views.push_back(std::move(view.view));
            manifest.files.merge(view.files);
        }
        if (frames->frames.size() > written.size())
            run.message(std::to_string(frames->frames.size() - written.size()) + " of " + std::to_string(frames->frames.size()) +
                        " frames have no uv map and are left out");
    }

    void run(RunContext& run) override
    {
        check_inputs();
        const auto folder = files.folder().path / path->path;
        std::filesystem::create_directories(folder);
        dataset::Manifest manifest;
        manifest.uv = *uv == "uint16" ? dataset::UvType::uint16 : dataset::UvType::float32;
        manifest.heights_px = uvmaps->heights_px;
        manifest.has_style = style.has_value();
        const auto write = [&](std::string_view name, const std::vector<std::byte>& bytes)
        { manifest.files.emplace(name, dataset::write_stamped(folder / name, bytes)); };
        if (style.has_value())
        {
            const auto npy = dataset::to_npy(style->pixels);
            dataset::picture_from(npy, "the picture on port 'style'");
            write(dataset::style_name, npy);
        }
        write(dataset::mesh_name, to_ply(*mesh));
        write_views(folder, manifest, run);

        const std::string text = dataset::to_text(manifest);
        // What the reader would refuse must not be written.
        dataset::parse_manifest(text, "the dataset");
        write_file(folder / dataset::manifest_name, text);
        tell(manifest, text.size(), run);
    }

    /// The manifest goes to --out last: a folder without it is no dataset.
    void tell(const dataset::Manifest& manifest, std::uint64_t manifest_bytes, RunContext& run)
    {
        Files result;
        std::uint64_t bytes = manifest_bytes;
        for (const auto& [name, stamp] : manifest.files)
        {
            result.names.push_back(path->path + "/" + name);
            bytes += stamp.bytes;
        }
        result.names.push_back(path->path + "/" + std::string(dataset::manifest_name));
        run.report("views", manifest.views.size());
        run.report("files", result.names.size());
        run.report("bytes", bytes);
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("dataset.write", DatasetWrite, "Writes uv maps, pictures and mesh as a folder of NPY files")
