#include "fly_path.h"
#include "video_file.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/images/filters.h>
#include <fresco/rendering/simplified.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <vector>

using namespace fresco;

namespace
{

/// How far the drawn surface may be off, seen from 1 m.
constexpr double most_error_px = 1.5;
/// A video has no alpha.
constexpr int background = 32;

class RenderFlythrough final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Input<Frames> frames{this, "frames", "The recording: its path and its color camera"};
    Output<Files> video{this, "video", "<name>.mp4 or .webm, or <name>/000000.png and so on"};
    Option<OutputName> name{this, "name", OutputName{"flythrough"}, "Name below --out, without extension"};
    Option<std::string> format{this, "format", "mp4", one_of({"mp4", "webm", "png"}),
                               "mp4: H.264, else MPEG-4; webm: VP9, else VP8; png: one picture per video frame"};
    Option<double> seconds{this, "seconds", 12, range(0.1, 3600), "Duration"};
    /// As films have it; players know it.
    static constexpr double fps = 25;
    Option<int> height_px{this, "height_px", 480, range(16, 4320), "Height; the width follows from the camera, both even"};
    /// Standard deviation in recorded frames: takes out the hand's shaking, keeps the way.
    static constexpr double smoothing_count = 6;
    Slot<ImageIo> images{this, "Encodes PNG pictures"};

    /// Intrinsics of the first frame's camera, in even numbers of pixels, which video codecs need.
    Intrinsics intrinsics() const
    {
        const Intrinsics& recorded = frames->frames.front().color.intrinsics;
        const int height = *height_px / 2 * 2;
        return recorded.scaled_to(std::max(2, (recorded.width_at(height) + 1) / 2 * 2), height);
    }

    std::vector<RigidTransform> poses() const
    {
        std::vector<RigidTransform> recorded;
        // One sequence: between two the camera was carried unseen.
        for (const Frame& frame : frames->frames)
            if (frame.sequence == frames->frames.front().sequence)
                recorded.push_back(frame.color.world_from_camera);
        const auto count = static_cast<std::size_t>(std::max(1L, std::lround(*seconds * fps)));
        return recorded_path(recorded, smoothing_count, count);
    }

    void run(RunContext& run) override
    {
        check_viewed(mesh->mesh, *frames, "what texture.bake made");
        const Intrinsics size = intrinsics();
        const TexturedMesh shown = rendering::simplified(*mesh, most_error_px / size.fx);
        const rendering::ViewRenderer renderer(shown, {.filter = rendering::TextureFilter::trilinear});
        const std::vector<RigidTransform> way = poses();
        const std::filesystem::path folder = video.folder().path;
        const bool pictures = *format == "png";
        Files made;
        std::optional<VideoFile> file;
        if (pictures)
            std::filesystem::create_directories(folder / name->path);
        else
        {
            made.names.push_back(name->path + "." + *format);
            std::filesystem::create_directories((folder / made.names.back()).parent_path());
            file.emplace(folder / made.names.back(), size.width, size.height, fps);
        }
        std::vector<Camera> cameras;
        for (const RigidTransform& pose : way)
            cameras.push_back({size, pose});
        if (pictures)
        {
            for (std::size_t i = 0; i < way.size(); ++i)
                made.names.push_back(fmt::format("{}/{:06}.png", name->path, i));
            renderer.render_each(cameras, run,
                                 [&](std::size_t i, const Raster8& picture)
                                 { write_file(folder / made.names[i], images->encode_png(on_gray(picture, background))); });
        }
        else
            renderer.render_in_order(cameras, run, [&](const Raster8& picture) { file->add(on_gray(picture, background)); });
        if (file)
        {
            file->close();
            run.report("codec", file->codec());
            run.report("bytes", static_cast<std::size_t>(std::filesystem::file_size(folder / made.names.front())));
        }
        run.report("pictures", way.size());
        run.report("width_px", size.width);
        run.report("height_px", size.height);
        video = std::move(made);
    }
};

}  // namespace

FRESCO_STAGE("render.flythrough", RenderFlythrough, "A video through the textured room")
FRESCO_LIBRARY("meshoptimizer", rendering::meshoptimizer_version())
