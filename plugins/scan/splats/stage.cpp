#include "camera_plan.h"
#include "cleaning.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>
#include <fresco/numerics/numerics.h>
#include <fresco/splats/render_splats.h>
#include <fresco/splats/splats.h>
#include <fresco/stage.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>

using namespace fresco;
using namespace scan_splats;

namespace
{

constexpr int jpeg_quality = 95;
/// As meshes and cameras.
constexpr double farthest_m = 1e7;
constexpr double most_depth_steps = 65'000;
/// Shares of needles. Of three good scans, one of them blurred, 0 to 5 %.
constexpr double many_needles = 0.2;
constexpr double only_needles = 0.5;
/// Two good scans have 0.01 and 0.09, one that is a heap of blobs 0.17.
constexpr double most_coarseness = 0.14;

class ScanSplats final : public Stage
{
    Option<InputPath> path{this, "path", required, "The splat: .ply, .splat, .spz, .sog or .glb, or the folder of a SOG"};
    Option<double> unit_m{this, "unit_m", 1.0, range(1e-6, 1e6), "Meters per unit of the file"};
    Option<std::string> up{this, "up", "auto", one_of({"auto", "x", "y", "z", "-x", "-y", "-z"}),
                           "Axis of the file that points up; auto: found by walls, level surfaces and furniture"};
    Choice<Stand> stand{this,
                        "stand",
                        Stand::automatic,
                        {{"auto", Stand::automatic}, {"inside", Stand::inside}, {"around", Stand::around}},
                        "Where cameras stand: inside a room or around an object; auto: where they see more"};
    Slot<ImageIo> images{this, "Reads and writes pictures"};
    Output<Frames> frames{this, "frames", "Rendered views with depth"};

    void run(RunContext& run) override
    {
        splats::SplatFile file = splats::read_splats(path->path);
        for (const auto& each : file.files)
            run.reads_file(each);
        const std::size_t all = file.splats.size();
        CleanedSplats clean = cleaned(std::move(file.splats));
        tell(all, clean, run);
        splats::Splats& scene = clean.splats;
        const Vec3d offset_m = bring_to_world(scene);
        tell_size(scene, file.format, run);
        const OpacityGrid grid(scene);
        const Places places = find_places(grid, *stand, run);
        const CameraPlan plan = plan_cameras(grid, places, up_of(scene, grid, places.inside, file.format, run), run);
        tell(grid, places, plan, run);
        Frames made;
        made.offset_m = offset_m;
        tell_offset(offset_m, run);
        for (const Camera& camera : plan.cameras)
        {
            run.progress(static_cast<double>(made.frames.size()), static_cast<double>(plan.cameras.size()), "views");
            made.frames.push_back(rendered(scene, camera, plan.nearest_m, made.frames.size(), run));
        }
        std::erase_if(made.frames, [](const Frame& frame) { return frame.depth_picture.empty(); });
        if (made.frames.empty())
            throw Error(path->path.string() + ": no camera sees a surface: all that is left of the splat is too transparent");
        run.report("views", made.frames.size());
        frames = std::move(made);
    }

    void tell(std::size_t all, const CleanedSplats& clean, RunContext& run) const
    {
        run.report("gaussians", all);
        run.report("faint", clean.faint);
        run.report("far", clean.far);
        run.report("giant", clean.giant);
        run.report("loose", clean.loose);
        run.report("needle_share", clean.needle_share);
        if (clean.splats.size() == 0)
            throw Error(
                fmt::format("{}: none of its {} Gaussians shows a surface: {} are too faint to be seen, {} far away, {} larger "
                            "than the scene",
                            path->path.string(), all, clean.faint, clean.far, clean.giant));
        run.message(fmt::format("{} Gaussians; left out: {} too faint to be seen, {} far away, {} giant, {} in loose specks", all,
                                clean.faint, clean.far, clean.giant, clean.loose));
        run.report("coarseness", clean.coarseness);
        if (clean.coarseness > most_coarseness)
            throw Error(
                fmt::format("{}: half of what is seen is blobs longer than {:.0f} % of the scene's radius: there is no "
                            "surface to paint. Train the splat to the end (30,000 steps), export it with more Gaussians, or "
                            "crop less",
                            path->path.string(), 100 * clean.coarseness));
        const std::string needles = fmt::format(
            "{:.0f} % of what is seen are streaks, more than 8 times as long as wide: the splat is half-trained or has "
            "too few pictures",
            100 * clean.needle_share);
        if (clean.needle_share > only_needles)
            throw Error(fmt::format("{}: {}; there is no surface to paint. Train it to the end (30,000 steps), or export it with "
                                    "a higher quality",
                                    path->path.string(), needles));
        if (clean.needle_share > many_needles)
            run.warning(needles + "; its surface will be rough");
    }

    void tell(const OpacityGrid& grid, const Places& places, const CameraPlan& plan, RunContext& run) const
    {
        run.report("inside", places.inside);
        run.report("inside_share", places.inside_share);
        run.report("around_share", places.around_share);
        run.report("seen_share", plan.seen_share);
        run.message(
            fmt::format("{} cameras {}, {:.2g} m from the middle to the farthest surface; if the other is right, set stand: {}",
                        plan.cameras.size(), places.inside ? "inside a room" : "around an object", grid.radius_m(),
                        places.inside ? "around" : "inside"));
    }

    /// Turns the splats into meters less an offset, which it returns.
    Vec3d bring_to_world(splats::Splats& scene) const
    {
        std::vector<Vec3d> centers;
        for (const Vec3f center : scene.centers)
        {
            const Vec3d at = vec_cast<double>(center) * *unit_m;
            if (std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) > farthest_m)
                throw Error(
                    fmt::format("{}: a Gaussian lies at {:g}, {:g}, {:g} m; expected at most {:g} m along each axis: check "
                                "unit_m",
                                path->path.string(), at.x, at.y, at.z, farthest_m));
            centers.push_back(at);
        }
        const Vec3d offset_m = offset_for(centers);
        for (std::size_t i = 0; i < centers.size(); ++i)
        {
            scene.centers[i] = vec_cast<float>(centers[i] - offset_m);
            scene.scales[i] = vec_cast<float>(vec_cast<double>(scene.scales[i]) * *unit_m);
        }
        return offset_m;
    }

    Vec3d up_of(const splats::Splats& scene, const OpacityGrid& grid, bool inside, splats::SplatFormat format,
                RunContext& run) const
    {
        if (*up != "auto")
        {
            const char axis = up->back();
            return Vec3d{axis == 'x' ? 1.0 : 0.0, axis == 'y' ? 1.0 : 0.0, axis == 'z' ? 1.0 : 0.0} *
                   (up->size() > 1 ? -1.0 : 1.0);
        }
        const Mesh squares = facing_squares(scene, grid, inside, run);
        const geometry::Upward found = geometry::find_up(squares, std::nullopt);
        run.report("up_next_share", found.next_share);
        run.report("up_shape_share", found.shape_share);
        if (found.from == geometry::UpEvidence::shape)
            return found.direction;
        // By its format, or else what stands on a floor is mostly near it.
        Vec3d guess = splats::is_metric(format) ? Vec3d{0, 1, 0} : found.direction;
        if (!splats::is_metric(format) && is_heavier_above(squares, guess))
            guess = -guess;
        run.warning(
            fmt::format("the splat does not clearly show which way is up, so {}{} is taken; if it comes out lying or upside "
                        "down, set up: x, y, z, -x, -y or -z",
                        guess.y + guess.z < 0 ? "-" : "", guess.y != 0 ? "y" : "z"));
        return guess;
    }

    static bool is_heavier_above(const Mesh& squares, Vec3d up)
    {
        double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
        for (const Vec3f corner : squares.positions)
        {
            const double height = dot(vec_cast<double>(corner), up);
            low = std::min(low, height);
            high = std::max(high, height);
            sum += height / static_cast<double>(squares.positions.size());
        }
        return sum > (low + high) / 2;
    }

    void tell_size(const splats::Splats& scene, splats::SplatFormat format, RunContext& run) const
    {
        numerics::Bounds<float> box;
        for (const Vec3f center : scene.centers)
            box.add(center);
        const Vec3d size = vec_cast<double>(box.high - box.low);
        run.report("extent_m", Value::List{size.x, size.y, size.z});
        const std::string measured = fmt::format("{:.2g} x {:.2g} x {:.2g} m", size.x, size.y, size.z);
        if (splats::is_metric(format) || *unit_m != 1)
            run.message(measured);
        else
            run.warning(fmt::format("{} files have no unit: in meters, the scene measures {}; if that is wrong, set unit_m",
                                    splats::name_of(format), measured));
    }

    /// Without a depth picture if the camera sees no surface.
    Frame rendered(const splats::Splats& scene, const Camera& camera, double nearest_m, std::size_t number, RunContext& run) const
    {
        const splats::SplatPicture picture = splats::render_splats(scene, camera, nearest_m, run);
        Frame frame;
        frame.sequence = "splat";
        frame.name = fmt::format("view-{:06}", number);
        frame.number = static_cast<long>(number);
        frame.color = frame.depth = camera;
        const float farthest = *std::ranges::max_element(picture.depth.values);
        if (!(farthest > 0))
            return frame;
        frame.depth_unit_m = static_cast<double>(farthest) / most_depth_steps;
        const int width = picture.depth.width, height = picture.depth.height;
        Raster8 color(width, height, 3), mask(width, height);
        Raster16 depth(width, height);
        for (std::size_t i = 0; i < depth.values.size(); ++i)
        {
            if (!(picture.depth.values[i] > 0))
                continue;
            mask.values[i] = 255;
            depth.values[i] =
                static_cast<std::uint16_t>(std::lround(static_cast<double>(picture.depth.values[i]) / frame.depth_unit_m));
            const float opaque = 1 - picture.transmittance.values[i];
            for (std::size_t c = 3 * i; c < 3 * i + 3; ++c)
                color.values[c] =
                    static_cast<std::uint8_t>(std::lround(255 * std::clamp(picture.color.values[c] / opaque, 0.0F, 1.0F)));
        }
        const auto file = [&](const char* ending) { return frames.folder().path / (frame.name + ending); };
        write_file(frame.color_picture.path = file(".color.jpg"), images->encode_jpeg(color, jpeg_quality));
        write_file(frame.depth_picture.path = file(".depth.png"), images->encode_png(depth));
        write_npy(frame.mask.path = file(".mask.npy"), mask);
        return frame;
    }
};

}  // namespace

FRESCO_STAGE("scan.splats", ScanSplats,
             "Views of a Gaussian splat, rendered with depth from cameras inside a room or around an object")
