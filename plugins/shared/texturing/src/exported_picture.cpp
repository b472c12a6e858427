#include <fresco/texturing/exported_picture.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/texturing/exported_file.h>
#include <fresco/texturing/smaller_picture.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <span>

namespace fresco::texturing
{
namespace
{

bool is_jpeg(std::string_view extension)
{
    return extension == ".jpg" || extension == ".jpeg";
}

std::array<std::size_t, 3> shape_of(const Raster8& picture)
{
    return {static_cast<std::size_t>(picture.height), static_cast<std::size_t>(picture.width),
            static_cast<std::size_t>(picture.channels)};
}

bool holds(const NpyArray& array, const Raster8& picture)
{
    const auto shape = shape_of(picture);
    if (array.shape != std::vector<std::size_t>(shape.begin(), shape.end()))
        return false;
    return std::ranges::equal(array.as<std::uint8_t>(), picture.values);
}

/// `jpeg_quality`: for .jpg and .jpeg.
std::vector<std::byte> encoded_picture(const Raster8& picture, std::string_view extension, int jpeg_quality,
                                       const ImageIo& images)
{
    if (extension == ".png")
        return images.encode_png(picture);
    if (is_jpeg(extension))
        return images.encode_jpeg(picture, jpeg_quality);
    if (extension == ".npy")
        return to_npy(NpyType::uint8, shape_of(picture), std::as_bytes(std::span(picture.values)));
    throw Error("unknown picture extension \"" + std::string(extension) + "\"; expected .png, .jpg or .npy");
}

}  // namespace

void check_path_for_names(const std::string& path)
{
    if (path.find_first_of(" \t\r\n") != std::string::npos)
        throw Error("path \"" + path + "\" must contain no spaces, where readers split names");
}

PictureEncoding::PictureEncoding(Configurable* owner, int max_texture_px)
    : jpeg_quality_(owner, "jpeg_quality", 92, range(1, 100), "Quality if the picture is JPEG"),
      max_texture_px_(owner, "max_texture_px", max_texture_px, range(0, 65536),
                      "Shrink the picture to this side, chart by chart in linear light; 0: do not shrink"),
      images_(owner, "images", "image.opencv", "Encodes the picture and reads it back")
{
}

PictureEncoding::Encoded PictureEncoding::encoded(const TexturedMesh& textured, std::string_view extension, RunContext& run) const
{
    Encoded result;
    if (*max_texture_px_ != 0 && *max_texture_px_ < textured.image.pixels.width)
        result.smaller = smaller_picture(textured, *max_texture_px_, run);
    result.bytes = encoded_picture(result.picture(textured), extension, *jpeg_quality_, *images_);
    run.check_canceled();
    return result;
}

void PictureEncoding::check(const std::filesystem::path& file, const Raster8& picture) const
{
    const std::string extension = file.extension().string();
    bool good = false;
    if (extension == ".npy")
        good = holds(read_npy(file), picture);
    else if (is_jpeg(extension))
    {
        const ImageHeader header = images_->check(file);
        good = header.width == picture.width && header.height == picture.height;
    }
    else
        good = images_->read_rgb(file) == picture;
    if (!good)
        throw Error(file.string() + ": the written picture differs from what was to be written");
}

PictureOptions::PictureOptions(Configurable* owner)
    : PictureEncoding(owner), image_format_(owner, "image_format", "png", one_of({"png", "jpeg"}), "How the picture is stored")
{
}

std::string PictureOptions::extension() const
{
    return *image_format_ == "jpeg" ? ".jpg" : ".png";
}

std::string PictureOptions::write(const TexturedMesh& textured, const std::filesystem::path& folder, const std::string& mesh_path,
                                  RunContext& run) const
{
    const std::string name = std::filesystem::path(mesh_path).replace_extension(extension()).generic_string();
    const Encoded image = encoded(textured, extension(), run);
    const Raster8& picture = image.picture(textured);
    write_file(folder / name, image.bytes);
    check(folder / name, picture);
    run.message(valid_line(name, image.bytes.size(), fmt::format("{0} x {0} texels", picture.width)));
    run.report("texture_px", picture.width);
    run.report("picture_bytes", image.bytes.size());
    return name;
}

}  // namespace fresco::texturing
