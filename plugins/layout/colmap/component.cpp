#include "model.h"

#include <fresco/files_io.h>
#include <fresco/recordings/layout.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

// Points of a thousand pictures with ten thousand each, as text.
constexpr std::size_t images_limit = std::size_t{1} << 32U;
/// Folders of a reconstruction, below the recording's.
constexpr std::array usual_folders{"",        "sparse/0/",        "sparse/",       "colmap/sparse/0/",
                                   "colmap/", "colmap_sparse/0/", "colmap_sparse/"};

class ColmapLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        std::string models;
        for (const char* folder : usual_folders)
            models += fmt::format("{}{}cameras.bin|{}cameras.txt", models.empty() ? "" : "|", folder, folder);
        return {.contains = {models}};
    }

  private:
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder of the pictures; empty: images, rgb or resized_images in path"};
    fresco::Option<fresco::InputFolder> depth{this, "depth", fresco::InputFolder{},
                                              "Folder of depth pictures, named like the pictures, .png; empty: none"};
    fresco::Option<fresco::InputFolder> masks{this, "masks", fresco::InputFolder{},
                                              "Folder of masks, black where to ignore the picture, named like it with .png added "
                                              "or in place of its ending; empty: none"};

    Recording list(fresco::RunContext& run) override
    {
        const auto [cameras_file, images_file] = find_model(run);
        const bool is_binary = cameras_file.extension() == ".bin";
        const auto cameras = is_binary ? colmap::parse_cameras_binary(fresco::read_file(cameras_file), cameras_file.string())
                                       : colmap::parse_cameras_text(fresco::read_text_file(cameras_file), cameras_file.string());
        const auto placed =
            is_binary ? colmap::parse_images_binary(fresco::read_file(images_file, images_limit), images_file.string())
                      : colmap::parse_images_text(fresco::read_text_file(images_file, images_limit), images_file.string());
        run.report("cameras", cameras.size());
        if (!masks->empty())
            looks_for(masks->path / "*.png", run);
        return {.views = colmap::model_views(cameras, placed, images_file,
                                             {.pictures = picture_folder(run), .depth = depth->path, .masks = masks->path})};
    }

    /// cameras.bin and images.bin, or else cameras.txt and images.txt, in the first of the usual folders.
    std::array<fs::path, 2> find_model(fresco::RunContext& run) const
    {
        std::string names;
        for (const char* place : usual_folders)
        {
            const auto folder = path() / place;
            for (const char* ending : {".bin", ".txt"})
            {
                const std::array files{folder / ("cameras" + std::string(ending)), folder / ("images" + std::string(ending))};
                for (const auto& file : files)
                    looks_for(file, run);
                if (!std::ranges::all_of(files, [](const auto& file) { return fs::is_regular_file(file); }))
                    continue;
                for (const auto& file : files)
                    run.reads_file(file);
                return files;
            }
            names += (names.empty() ? "" : ", ") + folder.string();
        }
        throw fresco::MissingInput(
            "no COLMAP reconstruction; expected cameras.bin and images.bin, or cameras.txt and images.txt, in " + names);
    }

    fs::path picture_folder(fresco::RunContext& run) const
    {
        if (!pictures->empty())
            return pictures->path;
        for (const char* name : {"images", "rgb", "resized_images"})
        {
            looks_for(path() / name, run);
            if (fs::is_directory(path() / name))
                return path() / name;
        }
        throw fresco::MissingInput(path().string() +
                                   ": there is no folder images (or rgb, resized_images); expected the "
                                   "reconstruction's pictures in it: put them there, or set option \"pictures\" "
                                   "to their folder");
    }
};

}  // namespace

FRESCO_COMPONENT("layout.colmap", ColmapLayout, fresco::recordings::Layout, "COLMAP reconstructions, text or binary")
