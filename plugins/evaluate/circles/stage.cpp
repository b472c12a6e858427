#include "circles.h"

#include <fresco/evaluation/posed_pictures.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/stage.h>

#include <fmt/format.h>

using namespace fresco;
using evaluation::PosedPicture;

namespace
{
constexpr int least_height_px = 784;

/// Results of one picture.
struct Seen
{
    std::vector<Circle> circles;
    ContourCounts counts;
};

class EvaluateCircles final : public Stage
{
    Input<Files> views{this, "views", optional, "Pictures to judge, as render.views makes them: <sequence>_<frame>.png"};
    Input<Frames> frames{this, "frames", "The frames whose color cameras took the pictures; their own pictures are not read"};
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", optional, "The mesh that the pictures show, with its picture"};
    Input<Mesh> mesh{this, "mesh", optional, "The room's mesh, if there is no textured one"};
    Output<Files> figures{this, "figures", "All figures and every circle as JSON"};
    Option<InputFolder> folder{this, "folder", InputFolder{},
                               "Folder of pictures made elsewhere (<sequence>_<frame>.png or .jpg), instead of port 'views'"};
    Option<int> every{this, "every", 1, range(1, 1'000'000), "Measure only every n-th picture"};
    Option<OutputName> path{this, "path", OutputName{"circles.json"}, "Name of the JSON file, below --out"};
    Slot<ImageIo> images{this, "Reads the pictures"};

    std::string name(const PosedPicture& posed) const
    {
        return frames->frames[posed.frame].sequence + "_" + frames->frames[posed.frame].name;
    }

    Seen look(const PosedPicture& posed, const raycast::Scene& scene) const
    {
        const Raster8 picture = images->read_rgb(posed.file);
        if (picture.height < least_height_px)
            throw Error(fmt::format("{}: is {} px high; circles need at least {} px: render the views with height_px: {} or more",
                                    posed.file.string(), picture.height, least_height_px, least_height_px));
        const Camera camera =
            evaluation::camera_of_picture(frames->frames[posed.frame], picture.width, picture.height, posed.file);
        const auto depth_at = [&](Vec2d pixel) -> std::optional<double>
        {
            const Vec3d direction = camera.ray(pixel.x, pixel.y);
            raycast::Hit hit;
            scene.cast(camera.world_from_camera.translation, {&direction, 1}, {&hit, 1});
            if (raycast::sight(hit) != raycast::Sight::surface)
                return std::nullopt;
            return hit.distance;
        };
        Seen seen;
        seen.circles = circles_on_surface(find_ellipses(picture, seen.counts), camera, depth_at);
        return seen;
    }

    static Value circle_value(const Circle& circle)
    {
        const Ellipse& e = circle.ellipse;
        Value::Map entry{{"center_px", Value::List{e.center.x, e.center.y}},
                         {"half_axes_px", Value::List{length(e.half_axis_1), length(e.half_axis_2)}},
                         {"depth_m", circle.depth},
                         {"radius_px", e.radius_px()}};
        if (circle.world)
        {
            entry.emplace_back("radius_m", circle.world->radius_m);
            entry.emplace_back("stretch", circle.world->stretch);
        }
        return entry;
    }

    Value::Map tell(const std::vector<Seen>& seen, RunContext& run) const
    {
        std::vector<std::vector<Circle>> circles;
        ContourCounts counts;
        std::size_t without = 0;
        for (const Seen& picture : seen)
        {
            circles.push_back(picture.circles);
            counts += picture.counts;
            without += picture.circles.empty() ? 1 : 0;
        }
        const CircleFigures all = circle_figures(circles, evaluation::usual_bootstrap);
        const std::size_t off_surface =
            counts.contours - counts.not_convex - counts.no_ellipse - counts.out_of_range - all.circles;
        Value::Map result{{"every", *every},
                          {"pictures", seen.size()},
                          {"pictures_without_circles", without},
                          {"circles", all.circles},
                          {"circles_3d", all.circles_3d},
                          {"contours", counts.contours},
                          {"contours_not_convex", counts.not_convex},
                          {"contours_without_ellipse", counts.no_ellipse},
                          {"ellipses_out_of_range", counts.out_of_range},
                          {"ellipses_off_surface", off_surface},
                          {"corr_2d", evaluation::figure(all.value.corr_2d, all.corr_2d)},
                          {"corr_3d", evaluation::figure(all.value.corr_3d, all.corr_3d)},
                          {"stretch", evaluation::figure(all.value.stretch, all.stretch)}};
        for (const auto& [key, value] : result)
            run.report(key, value);
        run.message("Corr2D " + evaluation::figure_text(all.value.corr_2d, all.corr_2d));
        run.message("Corr3D " + evaluation::figure_text(all.value.corr_3d, all.corr_3d));
        run.message("Stretch " + evaluation::figure_text(all.value.stretch, all.stretch));
        run.message(fmt::format("{} circles in {} pictures, {} with a radius in meters; of {} red contours {} are not convex",
                                all.circles, seen.size(), all.circles_3d, counts.contours, counts.not_convex));
        if (all.circles_3d < 2)
            run.warning("fewer than two circles were found: stylize with a picture of red circles and only the style loss");
        return result;
    }

    void run(RunContext& run) override
    {
        const Mesh& shown =
            evaluation::shown_mesh(textured_mesh.has_value() ? &*textured_mesh : nullptr, mesh.has_value() ? &*mesh : nullptr);
        check_offset(*frames, shown);
        auto pictures = evaluation::posed_pictures(*frames, views.has_value() ? &*views : nullptr, folder->path, run);
        std::erase_if(pictures, [&, i = 0](const PosedPicture&) mutable { return i++ % *every != 0; });
        const raycast::Scene scene(shown);
        std::vector<Seen> seen(pictures.size());
        parallel_for_each(pictures.size(), "pictures", run, [&](std::size_t i) { seen[i] = look(pictures[i], scene); });

        Value::Map result = tell(seen, run);
        Value::List list;
        for (std::size_t i = 0; i < pictures.size(); ++i)
        {
            Value::List circles;
            for (const Circle& circle : seen[i].circles)
                circles.push_back(circle_value(circle));
            list.push_back(Value::Map{{"picture", name(pictures[i])}, {"circles", std::move(circles)}});
        }
        result.emplace_back("picture_circles", std::move(list));
        figures = evaluation::write_figures(figures.folder(), path->path, result);
    }
};
}  // namespace

FRESCO_STAGE("evaluate.circles", EvaluateCircles,
             "Measures the circles of a stylized room: size against depth, and stretch on the surface")
FRESCO_LIBRARY("OpenCV", opencv_version())
FRESCO_LIBRARY("Embree", raycast::embree_version())
