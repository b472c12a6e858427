#include "view_pictures.h"

#include <fresco/error.h>
#include <fresco/evaluation/posed_pictures.h>
#include <fresco/npy.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <string>

namespace fresco::from_frames
{
namespace
{

std::string name_of(const Frame& frame)
{
    return frame.sequence + "_" + frame.name;
}

Raster8 read_rgb(const std::filesystem::path& file, const ImageIo* images)
{
    if (file.extension() != ".npy")
    {
        if (images == nullptr)
            throw Error(file.string() + ": no picture codec (option \"images\"); only NPY can be read without one");
        return images->read_rgb(file);
    }
    const NpyArray array = read_npy(file);
    if (array.type != NpyType::uint8 || array.shape.size() != 3 || array.shape[2] != 3)
        throw Error(file.string() + ": expected a picture, uint8 of height x width x 3");
    Raster8 picture(static_cast<int>(array.shape[1]), static_cast<int>(array.shape[0]), 3);
    std::memcpy(picture.values.data(), array.bytes.data(), picture.values.size());
    return picture;
}

}  // namespace

bool fits_camera(int width, int height, const Intrinsics& camera)
{
    const double aspect = static_cast<double>(camera.width) / camera.height;
    return std::abs(width - height * aspect) <= 1 || std::abs(height - width / aspect) <= 1;
}

ViewPictures::ViewPictures(const Frames& frames, const std::vector<std::size_t>& wanted, const std::filesystem::path& folder,
                           const ImageIo* images, RunContext& run)
    : frames_(frames), images_(images)
{
    if (folder.empty())
        return;
    files_.resize(frames.frames.size());
    for (const auto& picture : evaluation::posed_pictures(frames, nullptr, folder, run, evaluation::picture_or_npy))
        files_[picture.frame] = picture.file;
    std::vector<std::string> missing;
    for (const std::size_t frame : wanted)
        if (files_[frame].empty())
            missing.push_back(name_of(frames.frames[frame]));
    if (missing.empty())
        return;
    std::string names;
    constexpr std::size_t shown = 3;
    for (std::size_t i = 0; i < std::min(shown, missing.size()); ++i)
        names += (i > 0 ? ", " : "") + missing[i];
    throw MissingInput(
        fmt::format("{}: {} of {} frames have no picture in it: {}{}; expected <sequence>_<frame>.png, .jpg or .npy for each",
                    folder.string(), missing.size(), wanted.size(), names, missing.size() > shown ? ", …" : ""));
}

Raster8 ViewPictures::load(std::size_t frame) const
{
    if (files_.empty())
        return load_color(frames_.frames[frame], images_);
    Raster8 picture = read_rgb(files_[frame], images_);
    const Intrinsics& camera = frames_.frames[frame].color.intrinsics;
    if (!fits_camera(picture.width, picture.height, camera))
        throw Error(fmt::format(
            "{}: is {}x{}; the color camera of {} has {}x{}; pictures must show its whole view, at any size of that aspect ratio",
            files_[frame].string(), picture.width, picture.height, name_of(frames_.frames[frame]), camera.width, camera.height));
    return picture;
}

}  // namespace fresco::from_frames
