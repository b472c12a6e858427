#pragma once

#include <fresco/dataset/dataset_files.h>
#include <fresco/dataset/manifest.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/value.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// A dataset of two views of 20 x 16 at 8 and 20 px, made of noise; the second view has no depth picture. Kept in memory too, to
/// be compared with what is read.
class MadeDataset
{
  public:
    MadeDataset(const std::filesystem::path& folder, fresco::dataset::UvType uv, bool with_style) : folder_(folder)
    {
        manifest.uv = uv;
        manifest.heights_px = {8, 20};
        manifest.has_style = with_style;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 1, 1}};
        mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {1, 0}};
        mesh.texture_px = 512;
        write("mesh.ply", fresco::to_ply(mesh));
        if (with_style)
            write("style.npy", fresco::dataset::to_npy(style = noise<std::uint8_t>(9, 7, 3, 256)));
        for (std::size_t i = 0; i < 2; ++i)
            add_view(i);
        save();
    }

    /// Writes the manifest as it now is.
    void save() const { fresco::write_file(folder_ / "dataset.json", fresco::dataset::to_text(manifest)); }

    /// Replaces a file and its stamp: what is wrong with it then is not its hash.
    void replace(const std::string& name, const std::vector<std::byte>& bytes)
    {
        write(name, bytes);
        save();
    }

    fresco::dataset::Manifest manifest;
    fresco::Mesh mesh;
    fresco::Raster8 style;
    std::vector<fresco::Raster8> pictures;
    std::vector<fresco::Raster16> depths;
    std::vector<fresco::RasterF> uvs;  ///< Per view and height, as read back.

  private:
    template <class T>
    fresco::Raster<T> noise(int width, int height, int channels, std::int64_t below)
    {
        fresco::Raster<T> raster(width, height, channels);
        for (T& value : raster.values)
            value = static_cast<T>(random_.below(below));
        return raster;
    }

    void write(const std::string& name, const std::vector<std::byte>& bytes)
    {
        std::filesystem::create_directories((folder_ / name).parent_path());
        manifest.files[name] = fresco::dataset::write_stamped(folder_ / name, bytes);
    }

    void add_view(std::size_t i)
    {
        namespace dataset = fresco::dataset;
        dataset::View view;
        view.sequence = "seq";
        view.frame = "frame-" + std::to_string(i);
        view.number = static_cast<std::int64_t>(i);
        view.color.intrinsics = {20, 16, 15, 15, 10, 8};
        view.depth.intrinsics = {10, 8, 7, 7, 5, 4};
        view.sharpness = 7;
        pictures.push_back(noise<std::uint8_t>(20, 16, 3, 256));
        write(dataset::picture_name(i), dataset::to_npy(pictures.back()));
        if (i == 0)
        {
            view.depth_unit_m = 0.25;
            depths.push_back(noise<std::uint16_t>(10, 8, 1, 65536));
            write(dataset::sensor_depth_name(i), dataset::to_npy(depths.back()));
        }
        for (const int height : manifest.heights_px)
        {
            const int width = view.color.intrinsics.width_at(height);
            fresco::RasterF uv(width, height, 2);
            for (float& u : uv.values)
                u = static_cast<float>(random_.uniform());
            if (manifest.uv == dataset::UvType::uint16)
            {
                write(dataset::map_name(i, "uv", height), dataset::to_npy(dataset::quantized(uv)));
                uv = dataset::restored(dataset::quantized(uv));
            }
            else
                write(dataset::map_name(i, "uv", height), dataset::to_npy(uv));
            uvs.push_back(std::move(uv));
            write(dataset::map_name(i, "valid", height), dataset::to_npy(fresco::Raster8(width, height, 1, 1)));
            write(dataset::map_name(i, "depth", height), dataset::to_npy(fresco::RasterF(width, height, 1, 1.5F)));
            write(dataset::map_name(i, "cosine", height), dataset::to_npy(fresco::RasterF(width, height, 1, 0.5F)));
            write(dataset::map_name(i, "color", height), dataset::to_npy(noise<std::uint8_t>(width, height, 3, 256)));
            view.valid_pixels.push_back(width * height);
        }
        manifest.views.push_back(view);
    }

    std::filesystem::path folder_;
    fresco::Random random_{3};
};
