#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

#include <fmt/format.h>

namespace
{

constexpr std::size_t max_pixels = 300'000'000;

/// A picture of type uint8 and shape H x W, H x W x 1, H x W x 3 or H x W x 4. Throws MissingInput if the file cannot be read,
/// Error naming it and what it holds otherwise.
fresco::Raster8 picture_from_npy(const std::filesystem::path& file)
{
    const fresco::NpyArray array = fresco::read_npy(file);
    const auto& shape = array.shape;
    const std::string text = shape.empty() ? "()" : fmt::format("{}", fmt::join(shape, " x "));
    const std::size_t channels = shape.size() == 3 ? shape[2] : 1;
    if (array.type != fresco::NpyType::uint8 || (shape.size() != 2 && shape.size() != 3) ||
        (channels != 1 && channels != 3 && channels != 4))
        throw fresco::Error(file.string() + ": expected a picture, uint8 of height x width x 3 (or 1, or 4); found " + text +
                            (array.type == fresco::NpyType::uint8 ? "" : " of a different type"));
    if (shape[0] == 0 || shape[1] == 0 || shape[0] > max_pixels / shape[1])
        throw fresco::Error(
            fmt::format("{}: a picture of {}; expected 1 to {} million pixels", file.string(), text, max_pixels / 1'000'000));
    fresco::Raster8 pixels;
    pixels.height = static_cast<int>(shape[0]);
    pixels.width = static_cast<int>(shape[1]);
    pixels.channels = static_cast<int>(channels);
    const auto values = array.as<std::uint8_t>();
    pixels.values.assign(values.begin(), values.end());
    return pixels;
}

class ReadImage final : public fresco::FileReader
{
    fresco::Slot<fresco::ImageIo> images{this, fresco::optional, "Decodes all but NPY; none: only NPY"};

    std::string artifact() const override { return std::string(fresco::Image::artifact_name); }
    std::vector<fresco::FileFormat> formats() const override
    {
        std::vector<fresco::FileFormat> all = fresco::picture_formats();
        all.push_back(fresco::npy_format());
        return all;
    }

    std::shared_ptr<const fresco::Artifact> read(const std::filesystem::path& file) override
    {
        const std::string extension = file.extension().string();
        if (extension == ".npy" || extension == ".NPY")
            return std::make_shared<fresco::Image>(picture_from_npy(file));
        if (!images.has_value())
            throw fresco::Error(file.string() +
                                ": no picture codec (option \"images\"); only NPY pictures can be read without one");
        return std::make_shared<fresco::Image>(fresco::read_picture(*images, file));
    }
};

}  // namespace

FRESCO_COMPONENT("read.image", ReadImage, fresco::FileReader, "Pictures from PNG, JPEG, WebP, HEIC, AVIF and NPY files")
