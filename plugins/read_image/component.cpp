#include "npy_image.h"

#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

namespace
{

class ReadImage final : public fresco::FileReader
{
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", fresco::optional, "Decodes all but NPY; none: only NPY"};

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
            return std::make_shared<fresco::Image>(read_image::image_from_npy(file));
        if (!images.has_value())
            throw fresco::Error(file.string() +
                                ": no picture codec (option \"images\"); only NPY pictures can be read without one");
        return std::make_shared<fresco::Image>(images->read_rgb(file));
    }
};

}  // namespace

FRESCO_COMPONENT("read.image", ReadImage, fresco::FileReader, "Pictures from PNG, JPEG, WebP, HEIC, AVIF and NPY files")
