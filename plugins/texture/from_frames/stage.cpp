#include "frames_texture.h"

#include <fresco/evaluation/posed_pictures.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texture_pictures.h>
#include <fresco/uv_mapping/view_frames.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

std::string name_of(const Frame& frame)
{
    return frame.sequence + "_" + frame.name;
}

/// Per frame: its picture in a folder. Throws MissingInput that counts the `wanted` frames without one and names the first ones;
/// Error if two files are for one frame.
std::vector<std::filesystem::path> pictures_in(const std::filesystem::path& folder, const Frames& frames,
                                               const std::vector<std::size_t>& wanted, RunContext& run)
{
    std::vector<std::filesystem::path> files(frames.frames.size());
    for (const auto& picture : evaluation::posed_pictures(frames, nullptr, folder, run, evaluation::picture_or_npy))
        files[picture.frame] = picture.file;
    std::vector<std::string> missing;
    for (const std::size_t frame : wanted)
        if (files[frame].empty())
            missing.push_back(name_of(frames.frames[frame]));
    constexpr std::size_t shown = 3;
    if (!missing.empty())
        throw MissingInput(fmt::format(
            "{}: {} of {} frames have no picture in it: {}{}; expected <sequence>_<frame>.png, .jpg or .npy for each",
            folder.string(), missing.size(), wanted.size(),
            fmt::join(std::span(missing).first(std::min(shown, missing.size())), ", "), missing.size() > shown ? ", …" : ""));
    return files;
}

/// RGB, or RGBA with transparent pixels.
Raster8 read(const std::filesystem::path& file, const ImageIo* images)
{
    if (file.extension() != ".npy")
    {
        if (images == nullptr)
            throw Error(file.string() + ": no picture codec (option \"images\"); only NPY can be read without one");
        return read_picture(*images, file);
    }
    Raster8 picture = to_raster<std::uint8_t>(read_npy(file), file.string());
    if (picture.channels != 3)
        throw Error(file.string() + ": expected a picture, uint8 of height x width x 3");
    return picture;
}

/// A picture in place of the frame's own, of the camera's aspect ratio to a pixel in width or height.
Raster8 picture_for(const Frame& frame, const std::filesystem::path& file, const ImageIo* images)
{
    Raster8 picture = read(file, images);
    const Intrinsics& camera = frame.color.intrinsics;
    const double aspect = static_cast<double>(camera.width) / camera.height;
    if (std::abs(picture.width - picture.height * aspect) > 1 && std::abs(picture.height - picture.width / aspect) > 1)
        throw Error(fmt::format(
            "{}: is {}x{}; the color camera of {} has {}x{}; pictures must show its whole view, at any size of that aspect ratio",
            file.string(), picture.width, picture.height, name_of(frame), camera.width, camera.height));
    return picture;
}

/// Takes what the picture does not show, its transparent pixels, out of the map.
void leave_out_transparent(from_frames::View& view, const std::string& source)
{
    if (view.picture.channels != 4)
        return;
    bool is_opaque_anywhere = false;
    for (std::size_t i = 3; i < view.picture.values.size(); i += 4)
        is_opaque_anywhere = is_opaque_anywhere || view.picture.values[i] >= least_opaque_alpha;
    if (!is_opaque_anywhere)
    {
        std::ranges::fill(view.map.valid.values, std::uint8_t{0});
        view.picture = Raster8(view.picture.width, view.picture.height, 3);
        return;
    }
    texturing::OpaquePicture opaque = texturing::opaque_picture(view.picture, source, Progress());
    const Raster8 shown = mask_at(opaque.opaque, view.map.valid.width, view.map.valid.height);
    for (std::size_t i = 0; i < shown.values.size(); ++i)
        if (shown.values[i] == 0)
            view.map.valid.values[i] = 0;
    view.picture = std::move(opaque.rgb);
}

class TextureFromFrames final : public Stage
{
    Input<UvMaps> uvmaps{this, "uvmaps", "Which texel each pixel of each view sees"};
    Input<Frames> frames{this, "frames", "The frames that the uv maps were made for, with their pictures"};
    Output<Texture> texture{this, "texture", "What the pictures show, in one layer, in steps of 1/255"};

    Option<int> size_px{this, "size_px", 0, range(0, 16384),
                        "Texels per side of the texture; 0: as the uv maps say, which have it from the atlas"};
    Option<int> height_px{this, "height_px", 0, range(0, 8192), "Height of the uv maps to use; 0: the largest"};
    Option<InputFolder> pictures{this, "pictures", InputFolder{},
                                 "Folder of pictures in place of the cameras' (<sequence>_<frame>.png, .jpg or .npy), in any "
                                 "size of the camera's aspect ratio, such as stylized frames; transparent pixels show nothing"};
    Option<int> views_count{this, "views_count", 16, range(1, 63), "Maximum number of views to blend per texel, best first"};
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY; none: all are NPY"};

    std::size_t level() const
    {
        const auto& heights = uvmaps->heights_px;
        const auto wanted = *height_px == 0 ? std::max_element(heights.begin(), heights.end())
                                            : std::find(heights.begin(), heights.end(), *height_px);
        if (wanted != heights.end())
            return static_cast<std::size_t>(wanted - heights.begin());
        throw Error(fmt::format("option \"height_px\": no uv maps of {} px; found {}", *height_px, fmt::join(heights, ", ")));
    }

    from_frames::TextureRules rules(RunContext& run) const
    {
        constexpr const char* source = "the uv maps on port 'uvmaps'";
        const int size = painted_size_px(*size_px, uvmaps->texture_px, source, run);
        check_uv_bits(*uvmaps, size, source);
        return {.size_px = size, .views_count = *views_count};
    }

    /// A texture of 4096 texels a side.
    double memory_mb() const override { return 2000; }

    void run(RunContext& run) override
    {
        const std::size_t used_level = level();
        const from_frames::TextureRules used_rules = rules(run);
        const auto frame_of = frames_of_views(*uvmaps, *frames);
        std::vector<std::size_t> views;
        std::vector<std::size_t> wanted;
        for (std::size_t i = 0; i < uvmaps->views.size(); ++i)
            if (uvmaps->views[i].valid_pixels.at(used_level) > 0)
            {
                views.push_back(i);
                wanted.push_back(frame_of[i]);
            }
        if (views.empty())
            throw Error(fmt::format("none of the {} views sees the mesh: check that mesh and poses share one world frame",
                                    uvmaps->views.size()));
        const ImageIo* const codec = images.has_value() ? images.get().get() : nullptr;
        const bool own = pictures->empty();
        const auto files = own ? std::vector<std::filesystem::path>() : pictures_in(pictures->path, *frames, wanted, run);
        const auto read = [&](std::size_t i, bool with_depth)
        {
            const Frame& frame = frames->frames[wanted[i]];
            from_frames::View view{uvmaps->load_map(views[i], used_level),
                                   uvmaps->views[views[i]].camera,
                                   own ? load_color(frame, codec) : picture_for(frame, files[wanted[i]], codec),
                                   {},
                                   frame.sequence};
            if (!own)
                leave_out_transparent(view, files[wanted[i]].string());
            if (with_depth && !frame.depth_picture.empty())
                view.measured = sensor_depth(view.map, view.camera, frame.depth, load_depth(frame, codec));
            return view;
        };
        auto made = from_frames::frames_texture(views.size(), read, used_rules, run);
        tell(made, run);
        // The pictures have 8 bits, and the store packs such steps to a quarter.
        for (float& value : made.picture.values)
            value = std::round(std::clamp(value, 0.0F, 1.0F) * 255) / 255;
        Texture result;
        result.atlas = uvmaps->atlas;
        result.layers.push_back(std::move(made.picture));
        result.seen = std::move(made.seen);
        texture = std::move(result);
    }

    void tell(const from_frames::FramesTexture& made, RunContext& run) const
    {
        const auto share = [](std::size_t part, std::size_t whole)
        { return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0; };
        const auto seen = static_cast<std::size_t>(std::count(made.seen.values.begin(), made.seen.values.end(), 1));
        run.report("views", made.gains.size());
        run.report("height_px", uvmaps->heights_px[level()]);
        run.report("seen_share", share(seen, made.seen.values.size()));
        run.report("samples_per_texel", share(made.blended_samples, seen));
        run.report("rejected_samples", made.rejected_samples);
        run.report("rejected_share", share(made.rejected_samples, made.blended_samples));
        run.report("edge_pixel_share", share(made.edge_pixels, made.pixels));
        run.report("occluded_pixel_share", share(made.occluded_pixels, made.pixels));
        float least_gain = 1;
        float most_gain = 1;
        for (const auto& gains : made.gains)
        {
            const auto [least, most] = std::minmax_element(gains.values.begin(), gains.values.end());
            least_gain = std::min(least_gain, *least);
            most_gain = std::max(most_gain, *most);
        }
        run.report("least_gain", least_gain);
        run.report("most_gain", most_gain);
        run.report("local_error", made.error);
        run.report("local_error_without_gains", made.error_without_gains);
        const auto [blurred, sharp] = std::minmax_element(made.sharpness.begin(), made.sharpness.end());
        run.report("least_sharpness_factor", *blurred);
        run.report("most_sharpness_factor", *sharp);
        if (made.occluded_pixels * 2 > made.pixels)
            run.warning(
                fmt::format("the measured depth disagrees with the mesh at {:.0f} % of the pixels, which are not used: check "
                            "that poses, depth and mesh belong to one recording",
                            100 * share(made.occluded_pixels, made.pixels)));
    }
};

}  // namespace

FRESCO_STAGE("texture.from_frames", TextureFromFrames, "Blends the camera pictures, or others in their place, into a texture")
