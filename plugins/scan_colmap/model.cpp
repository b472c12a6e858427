#include "model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/recordings/recording_stage.h>

#include <fmt/format.h>

namespace colmap
{
namespace
{

namespace fs = std::filesystem;

// Points of a thousand pictures with ten thousand each, as text.
constexpr std::size_t images_limit = std::size_t{1} << 32U;

}  // namespace

ModelFiles find_model(const fs::path& path, fresco::RunContext& run)
{
    std::string names;
    for (const char* place : {"", "sparse/0", "sparse", "colmap/sparse/0", "colmap", "colmap_sparse/0", "colmap_sparse"})
    {
        const auto folder = *place == '\0' ? path : path / place;
        for (const char* ending : {".bin", ".txt"})
        {
            const ModelFiles files{folder / ("cameras" + std::string(ending)), folder / ("images" + std::string(ending))};
            for (const auto& file : {files.cameras, files.images})
                fresco::recordings::looks_for(file, run);
            if (!fs::is_regular_file(files.cameras) || !fs::is_regular_file(files.images))
                continue;
            run.reads_file(files.cameras);
            run.reads_file(files.images);
            return files;
        }
        names += (names.empty() ? "" : ", ") + folder.string();
    }
    throw fresco::MissingInput(
        "no COLMAP reconstruction; expected cameras.bin and images.bin, or cameras.txt and images.txt, in " + names);
}

Cameras read_cameras(const fs::path& file)
{
    return file.extension() == ".bin" ? parse_cameras_binary(fresco::read_file(file), file.string())
                                      : parse_cameras_text(fresco::read_text_file(file), file.string());
}

std::vector<ModelImage> read_images(const fs::path& file)
{
    return file.extension() == ".bin" ? parse_images_binary(fresco::read_file(file, images_limit), file.string())
                                      : parse_images_text(fresco::read_text_file(file, images_limit), file.string());
}

std::vector<fresco::recordings::RecordedView> model_views(const Cameras& cameras, const std::vector<ModelImage>& images,
                                                          const fs::path& images_file, const ViewOptions& options)
{
    if (images.empty())
        throw fresco::Error(images_file.string() + ": the reconstruction has no images: COLMAP placed none of them");
    std::vector<fresco::recordings::RecordedView> views;
    for (const auto& image : images)
    {
        const auto camera = cameras.find(image.camera);
        if (camera == cameras.end())
            throw fresco::Error(fmt::format("{}: the camera {} is not in the cameras file; use both files of one reconstruction",
                                            image.source, image.camera));
        fresco::recordings::RecordedView view;
        fresco::recordings::name_by_picture(view, image.name);
        view.color = options.pictures / image.name;
        if (!options.depth.empty())
            view.depth = (options.depth / image.name).replace_extension(".png");
        if (!options.masks.empty())
        {
            view.mask = options.masks / (image.name + ".png");
            if (!fs::is_regular_file(view.mask))
                view.mask = (options.masks / image.name).replace_extension(".png");
        }
        view.is_panorama = camera->second.is_panorama;
        view.camera = camera->second.intrinsics;
        view.lens = camera->second.lens;
        view.world_from_camera = image.world_from_camera;
        view.world_from_camera.translation = view.world_from_camera.translation * options.unit_m;
        view.depth_unit_m = options.depth_unit_m;
        view.source = image.source;
        views.push_back(std::move(view));
    }
    fresco::recordings::order_by_name(views);
    return views;
}

}  // namespace colmap
