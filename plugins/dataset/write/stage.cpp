#include "loader_text.h"
#include "stylemesh_layout.h"
#include "view_writer.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/run_context.h>
#include <fresco/stage.h>
#include <fresco/uv_maps.h>
#include <fresco/wording.h>

#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <functional>
#include <optional>
#include <span>

using namespace fresco;

namespace
{

constexpr const char* loader_name = "fresco_dataset.py";
constexpr const char* writer = "fresco " FRESCO_VERSION;
constexpr const char* stylemesh_manifest = "manifest.json";

class DatasetWrite final : public Stage
{
    Input<UvMaps> uvmaps{this, "uvmaps", "The uv maps of the views to write"};
    Input<Frames> frames{this, "frames", "The frames that the uv maps were made from, with their pictures"};
    Input<Mesh> mesh{this, "mesh", "The mesh that the uv maps show, with texcoords"};
    Input<Image> style{this, "style", optional, "The style picture"};
    Input<Table> agreement{this, "agreement", optional, "How well pictures and mesh agree, as frames.align measured it"};
    Output<Files> files{this, "files", "The dataset's folder: its manifest and the files that it lists"};
    Option<OutputName> path{this, "path", OutputName{"dataset"}, "Folder to write, below --out"};
    Option<std::string> uv{this, "uv", "float32", one_of({"float32", "uint16"}),
                           "How texcoords are stored: unchanged, or as round(65535 u) in half the space"};
    Option<bool> pictures{this, "pictures", false,
                          "Also write transforms.json (nerfstudio), images/ and depth/ for other programs"};
    Option<std::string> layout{
        this, "layout", "fresco", one_of({"fresco", "stylemesh"}),
        "fresco: fresco's own layout; stylemesh: the folders that StyleMesh's released training code reads"};
    Option<std::string> scene{this, "scene", "scene0000_00",
                              "Scene name for layout: stylemesh: two parts of letters and digits joined by _"};
    Slot<ImageIo> images{this, "Reads the frames' pictures, and writes picture files"};

    void check_inputs() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        check_offset(*frames, *mesh);
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: wire the mesh that the uv maps were made from");
        if (uvmaps->views.empty() || uvmaps->heights_px.empty())
            throw Error("port 'uvmaps' has no uv maps: check that the cameras see the mesh");
        if (*uv == "uint16" && uv_bits_for_texture(std::max(uvmaps->texture_px, 1)) > 16)
            throw Error(fmt::format("option \"uv\": uint16 is for textures up to 4096 texels a side, the uv maps on port "
                                    "'uvmaps' are for {}: set uv: float32",
                                    uvmaps->texture_px));
    }

    /// Throws Error unless the table is one of frames.align.
    std::optional<dataset::Agreement> measured_agreement() const
    {
        if (!agreement.has_value())
            return std::nullopt;
        const std::vector<std::string> expected{"error_before", "error_after", "median_moved_px", "most_moved_px"};
        if (agreement->columns != expected || agreement->rows.size() != 1)
            throw Error("the table on port 'agreement' has other columns than " + join(expected) +
                        ", or not one row: wire a frames.align stage");
        const auto& row = agreement->rows.front();
        return dataset::Agreement{row[0].as_double(), row[1].as_double(), row[2].as_double(), row[3].as_double()};
    }

    /// The files of every view, also in `folder`: those that an interrupted run had finished are not made again.
    std::vector<WrittenFiles>
    write_views(const std::filesystem::path& folder, std::size_t count, RunContext& run,
                const std::function<WrittenFiles(const std::filesystem::path&, std::size_t)>& write) const
    {
        const KeptPieces kept(run);
        std::vector<WrittenFiles> written(count);
        std::atomic<std::size_t> found{0};
        parallel_for_each(count, "views", run,
                          [&](std::size_t i)
                          {
                              if (const auto earlier = kept.find(i))
                              {
                                  written[i] = written_files_from(*earlier);
                                  ++found;
                                  return;
                              }
                              written[i] = write(kept.folder(), i);
                              kept.note(i, written[i].names(), to_value(written[i]));
                          });
        if (found > 0)
            run.message(fmt::format("{} of {} views were there from an interrupted run", found.load(), count));
        for (const WrittenFiles& view : written)
            kept.link(view.names(), folder);
        return written;
    }

    void run(RunContext& run) override
    {
        check_inputs();
        const auto frame_of = checked_frames(*uvmaps, *frames);
        if (frames->frames.size() > frame_of.size())
            run.message(fmt::format("{} of {} frames have no uv map and are left out", frames->frames.size() - frame_of.size(),
                                    frames->frames.size()));
        const auto folder = files.folder().path / path->path;
        std::filesystem::create_directories(folder);
        if (*layout == "stylemesh")
            write_stylemesh(folder, frame_of, run);
        else
            write_fresco(folder, frame_of, run);
    }

    void write_fresco(const std::filesystem::path& folder, const std::vector<std::size_t>& frame_of, RunContext& run)
    {
        dataset::Manifest manifest;
        manifest.writer = writer;
        manifest.uv = *uv == "uint16" ? dataset::UvType::uint16 : dataset::UvType::float32;
        manifest.heights_px = uvmaps->heights_px;
        manifest.has_style = style.has_value();
        manifest.agreement = measured_agreement();
        const auto write = [&](std::string_view name, std::span<const std::byte> bytes)
        { manifest.files.emplace(name, dataset::write_stamped(folder / name, bytes)); };
        const auto write_text = [&](std::string_view name, std::string_view text)
        { write(name, std::as_bytes(std::span(text))); };
        if (style.has_value())
        {
            const auto npy = dataset::to_npy(style->pixels);
            dataset::picture_from(npy, "the picture on port 'style'");
            write(dataset::style_name, npy);
        }
        write(dataset::mesh_name, to_ply(*mesh));
        write_text(loader_name, loader_text);
        const ViewOptions options{.uv = manifest.uv, .pictures = *pictures};
        const auto written =
            write_views(folder, frame_of.size(), run,
                        [&](const std::filesystem::path& to, std::size_t i)
                        { return write_view(to, *uvmaps, i, frames->frames[frame_of[i]], images.get().get(), options); });
        for (std::size_t i = 0; i < written.size(); ++i)
        {
            manifest.views.push_back(view_entry(*uvmaps, i, frames->frames[frame_of[i]], written[i]));
            manifest.files.insert(written[i].files.begin(), written[i].files.end());
        }
        if (*pictures)
            write_text(transforms_name, transforms_text(manifest));

        const std::string text = dataset::to_text(manifest);
        // A dataset that the reader would refuse must not be written.
        dataset::parse_manifest(text, "the dataset");
        finish(folder, manifest.files, dataset::manifest_name, text, frame_of.size(), run);
    }

    void write_stylemesh(const std::filesystem::path& folder, const std::vector<std::size_t>& frame_of, RunContext& run)
    {
        if (style.has_value())
            run.message("layout: stylemesh has no place for the style picture: it is left out");
        const StylemeshLayout scene_folder(*scene, *uvmaps, *frames, frame_of);
        WrittenFiles all = scene_folder.write_scene(folder, *mesh);
        const auto written =
            write_views(folder, frame_of.size(), run,
                        [&](const std::filesystem::path& to, std::size_t i) { return scene_folder.write_view(to, i, *images); });
        for (const WrittenFiles& view : written)
            all.files.insert(view.files.begin(), view.files.end());
        finish(folder, all.files, stylemesh_manifest, stylemesh_text(scene_folder, frame_of, all.files), frame_of.size(), run);
    }

    std::string stylemesh_text(const StylemeshLayout& scene_folder, const std::vector<std::size_t>& frame_of,
                               const std::map<std::string, dataset::FileStamp>& written) const
    {
        Value::List views;
        for (std::size_t i = 0; i < frame_of.size(); ++i)
            views.emplace_back(Value::Map{{"number", static_cast<std::int64_t>(scene_folder.number(i))},
                                          {"sequence", frames->frames[frame_of[i]].sequence},
                                          {"frame", frames->frames[frame_of[i]].name}});
        Value manifest = Value::Map{{"layout", "stylemesh"},
                                    {"writer", writer},
                                    {"scene", *scene},
                                    {"heights_px", Value::List(uvmaps->heights_px.begin(), uvmaps->heights_px.end())}};
        if (const auto measured = measured_agreement())
            manifest.set("agreement", dataset::to_value(*measured));
        manifest.set("views", std::move(views));
        manifest.set("files", dataset::stamps_value(written));
        return to_json(manifest, 1) + "\n";
    }

    /// The manifest goes to --out last: a folder without it is not a dataset.
    void finish(const std::filesystem::path& folder, const std::map<std::string, dataset::FileStamp>& written,
                std::string_view manifest_name, const std::string& manifest_text, std::size_t views, RunContext& run)
    {
        write_file(folder / manifest_name, manifest_text);
        Files result;
        std::uint64_t bytes = manifest_text.size();
        for (const auto& [name, stamp] : written)
        {
            result.names.push_back(path->path + "/" + name);
            bytes += stamp.bytes;
        }
        result.names.push_back(path->path + "/" + std::string(manifest_name));
        run.report("views", views);
        run.report("files", result.names.size());
        run.report("bytes", bytes);
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("dataset.write", DatasetWrite, "Writes uv maps, pictures and mesh as a folder of NPY files")
