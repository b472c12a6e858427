#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <atomic>
#include <fmt/format.h>
#include <set>
#include <string>
#include <vector>

using namespace fresco;

namespace
{
class RenderViews final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Input<Frames> frames{this, "frames", "The views; their color cameras are used, not their pictures"};
    Output<Files> views{this, "views", "One RGBA PNG per view: <folder>/<sequence>_<frame>.png; alpha 0: no surface"};
    Option<OutputName> folder{this, "folder", OutputName{"views"}, "Folder of the pictures, below --out"};
    Option<int> height_px{this, "height_px", 0, range(0, 8192),
                          "Height of the pictures, the width follows; 0: the camera's own size"};
    Option<int> every_count{this, "every_count", 1, range(1, 1'000'000), "Render every n-th frame"};
    Option<int> samples{this, "samples", 2, range(1, 8),
                        "Samples per pixel along each side, against aliasing at edges and far away"};
    rendering::FilterOption filter{this};
    Option<std::string> shading = rendering::shading_option(this);
    Option<bool> through_backs{this, "through_backs", false,
                               "Look through the backs of faces, so that a room seen from above shows its inside"};
    Slot<ImageIo> images{this, "Encodes the pictures"};

    Camera camera_of(const Frame& frame) const
    {
        Camera camera = frame.color;
        if (*height_px > 0)
            camera.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(*height_px), *height_px);
        return camera;
    }

    std::vector<const Frame*> chosen() const
    {
        std::vector<const Frame*> result;
        std::set<std::string> names;
        for (std::size_t i = 0; i < frames->frames.size(); i += static_cast<std::size_t>(*every_count))
        {
            const Frame& frame = frames->frames[i];
            if (!names.insert(frame.sequence + "_" + frame.name).second)
                throw Error("two frames would be written as " + frame.sequence + "_" + frame.name +
                            ".png: rename the scan's sequences so that they differ");
            result.push_back(&frame);
        }
        return result;
    }

    void run(RunContext& run) override
    {
        rendering::check_showable(*mesh, *frames);
        const std::vector<const Frame*> list = chosen();
        const rendering::ViewRenderer renderer(*mesh, {.samples_per_side = *samples,
                                                       .filter = *filter,
                                                       .lights = rendering::lights_of(*shading),
                                                       .through_backs = *through_backs});
        std::filesystem::create_directories(views.folder().path / folder->path);
        Files result;
        std::vector<Camera> cameras;
        for (const Frame* frame : list)
        {
            cameras.push_back(camera_of(*frame));
            result.names.push_back(folder->path + "/" + frame->sequence + "_" + frame->name + ".png");
        }
        std::atomic<std::size_t> empty = 0;
        renderer.render_each(cameras, run,
                             [&](std::size_t i, const Raster8& image)
                             {
                                 bool any = false;
                                 for (std::size_t a = 3; a < image.values.size(); a += 4)
                                     any = any || image.values[a] > 0;
                                 empty += any ? 0 : 1;
                                 write_file(views.folder().path / result.names[i], images->encode_png(image));
                             });
        run.report("views", list.size());
        run.report("empty_views", empty.load());
        if (empty > 0)
            run.warning(fmt::format("{} of {} views show no surface", empty.load(), list.size()));
        views = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("render.views", RenderViews, "Renders the textured mesh from the frames' color cameras")
