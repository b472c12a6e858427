#include <fresco/frames.h>
#include <fresco/hole_closer.h>
#include <fresco/image_io.h>
#include <fresco/inspection/diagnosis.h>
#include <fresco/inspection/views.h>
#include <fresco/mesh.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/stage.h>

#include "integration.h"
#include "surface.h"
#include "vertex_colors.h"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

/// Frames that are held at once.
constexpr std::size_t batch = 8;
constexpr double gigabyte = 1e9;
constexpr std::size_t checked_frames = 12;
/// Shares of depths that agree. Below the first, the cause is searched; below the second, a certain mistake is an error.
constexpr double doubtful_share = 0.7;
constexpr double wrong_share = 0.5;
/// Frames that overlap less may be right although few depths agree.
constexpr std::ptrdiff_t fewest_overlapping_frames = 3;
constexpr double fewest_compared_depths = 1000;
constexpr double fewest_depths_of_frame = 8;
constexpr double least_voxel_m = 1e-4;
/// Frames of which pixels are measured, and one pixel of so many.
constexpr std::size_t sized_frames = 32;
constexpr std::size_t sized_pixels = 61;

/// The frames' depth pictures. Each is decoded once: its values stay in memory, as long as all that do take `most_bytes` at most.
/// Thread-safe.
class DepthPictures
{
  public:
    DepthPictures(const ImageIo* images, std::size_t most_bytes) : images_(images), most_bytes_(most_bytes) {}

    RasterF of(const Frame& frame)
    {
        const auto& file = frame.depth_picture.path;
        if (const Raster16* const kept = find(file))
            return depth_in_meters(*kept, frame.depth_unit_m);
        Raster16 steps = load_depth_steps(frame, images_);
        RasterF depth = depth_in_meters(steps, frame.depth_unit_m);
        keep(file, std::move(steps));
        return depth;
    }

    std::size_t bytes() const { return bytes_; }

  private:
    /// Null if it is not kept. What is kept stays where it is.
    const Raster16* find(const std::filesystem::path& file)
    {
        const std::scoped_lock lock(mutex_);
        const auto kept = kept_.find(file);
        return kept != kept_.end() ? &kept->second : nullptr;
    }

    void keep(const std::filesystem::path& file, Raster16 steps)
    {
        const std::size_t bytes = steps.values.size() * sizeof(std::uint16_t);
        const std::scoped_lock lock(mutex_);
        if (bytes_ + bytes <= most_bytes_ && kept_.try_emplace(file, std::move(steps)).second)
            bytes_ += bytes;
    }

    const ImageIo* images_;
    std::size_t most_bytes_;
    std::mutex mutex_;
    std::size_t bytes_ = 0;
    std::map<std::filesystem::path, Raster16> kept_;
};

class MeshFuse final : public Stage
{
    Input<Frames> frames{this, "frames", "Recorded frames with depth pictures"};
    Input<Mesh> given{this, "mesh", optional, "A mesh of the recording: nothing is fused, it is passed on"};
    Output<Mesh> mesh{this, "mesh", "The given mesh, else the surface that the depth pictures show, with vertex colors"};
    Option<double> voxel_m{this, "voxel_m", 0.01, range(0, 1),
                           "Side of a voxel, and about that of a triangle, from 0.0001; 0: two pixels of the depth pictures"};
    Option<double> max_depth_m{this, "max_depth_m", 5, range(0.1, 1000), "Ignore depth beyond this; noise grows with distance"};
    Option<double> min_component_m2{
        this, "min_component_m2", 0.01, range(0, 1000),
        "Remove separate pieces of surface with less area; with voxel_m 0, of at most 100 voxel sides"};
    Option<double> max_memory_gb{
        this, "max_memory_gb", 4, range(0.01, 10'000),
        "Stop with an error if volume and mesh need more; another quarter of it may hold depth pictures"};
    Option<bool> check_poses{
        this, "check_poses", true,
        "End with an error if depth pictures contradict each other or the given mesh; false: do not compare"};
    Slot<HoleCloser> holes{this, "holes", "", "Closes small holes, also of a given mesh; none: they stay open"};
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY; none: all are NPY"};

    const ImageIo* codec() const { return images.has_value() ? images.get().get() : nullptr; }
    std::size_t limit_bytes() const { return static_cast<std::size_t>(*max_memory_gb * gigabyte); }

    double voxel_ = 0;  ///< Meters.

    /// Distances are averaged up to this far from the surface: more than the depth noise. Rendered depth, for which voxel_m is 0,
    /// has little, and what lies behind one side of a thin board shifts the other.
    double truncation() const { return (*voxel_m > 0 ? 4 : 2) * voxel_; }

    double min_component() const { return *voxel_m > 0 ? *min_component_m2 : std::min(*min_component_m2, 100 * voxel_ * voxel_); }

    /// Twice the median width of a depth picture's pixel on the surface.
    double voxel_by_pixels(const std::vector<const Frame*>& measured, DepthPictures& depths, RunContext& run) const
    {
        std::vector<double> widths;
        for (const std::size_t i : numerics::evenly_spread(std::min(measured.size(), sized_frames), measured.size()))
        {
            run.check_canceled();
            const RasterF depth = depths.of(*measured[i]);
            for (std::size_t at = sized_pixels / 2; at < depth.values.size(); at += sized_pixels)
                if (const auto meters = static_cast<double>(depth.values[at]); meters > 0 && meters <= *max_depth_m)
                    widths.push_back(meters / measured[i]->depth.intrinsics.fx);
        }
        const double voxel = widths.empty() ? 1 : std::clamp(2 * numerics::median(std::move(widths)), least_voxel_m, 1.0);
        run.message(fmt::format("voxels of {:.2g} mm, two pixels of the depth pictures", 1000 * voxel));
        run.report("voxel_m", voxel);
        return voxel;
    }

    std::vector<const Frame*> frames_with_depth() const
    {
        std::vector<const Frame*> measured;
        for (const Frame& frame : frames->frames)
            if (!frame.depth_picture.empty())
                measured.push_back(&frame);
        return measured;
    }

    /// Makes something of each frame, a few at once, and passes those on in order, with the number of the first. `pass`: of
    /// three.
    template <class Item>
    void each_batch(const std::vector<const Frame*>& measured, int pass, RunContext& run,
                    const std::function<Item(const Frame&)>& make,
                    const std::function<void(std::vector<Item>&, std::size_t)>& use) const
    {
        for (std::size_t begin = 0; begin < measured.size(); begin += batch)
        {
            std::vector<Item> items(std::min(batch, measured.size() - begin));
            parallel_items(items.size(), 1, run, [&](std::size_t i) { items[i] = make(*measured[begin + i]); });
            use(items, begin);
            const auto total = static_cast<double>(measured.size());
            run.progress((pass * total + static_cast<double>(begin + items.size())) / 3, total, "frames");
        }
    }

    fuse::DepthView view_of(const Frame& frame, DepthPictures& depths) const
    {
        return fuse::depth_view(depths.of(frame), frame.depth, *max_depth_m);
    }

    [[noreturn]] void refuse_memory(const std::string& when) const
    {
        throw Error(when + " more than max_memory_gb (" + to_json(*max_memory_gb) +
                    "): raise max_memory_gb or voxel_m (memory falls with its square), or lower max_depth_m");
    }

    fuse::Volume fuse_frames(const std::vector<const Frame*>& measured, DepthPictures& depths, RunContext& run) const
    {
        using Places = std::vector<fuse::BlockPlace>;
        const fuse::OpenedBlocks opened{voxel_, truncation(), limit_bytes() / fuse::Volume::bytes_per_block};
        Places places;
        each_batch<Places>(
            measured, 0, run, [&](const Frame& frame) { return opened.near(view_of(frame, depths)); },
            [&](std::vector<Places>& near, std::size_t first)
            {
                for (std::size_t i = 0; i < near.size(); ++i)
                {
                    unite(places, near[i]);
                    if (places.size() > opened.most)
                        refuse_memory(fmt::format("with {} of {} frames, the volume needs", first + i + 1, measured.size()));
                }
            });
        fuse::Volume volume(voxel_, std::move(places));
        each_batch<fuse::DepthView>(
            measured, 1, run, [&](const Frame& frame) { return view_of(frame, depths); },
            [&](std::vector<fuse::DepthView>& views, std::size_t) { integrate(views, opened.reach_m, run, volume); });
        return volume;
    }

    Mesh extract(const fuse::Volume& volume, RunContext& run) const
    {
        const fuse::Surface surface(volume, run);
        if (volume.bytes() + surface.bytes() > limit_bytes())
            refuse_memory("volume and mesh need");
        Mesh made = surface.mesh(run);
        run.report("volume_bytes", volume.bytes());
        run.report("components_removed", fuse::remove_small_components(min_component(), made));
        if (made.triangles.empty())
            throw Error(
                "the depth pictures show no surface of at least min_component_m2: all depth is 0 or beyond max_depth_m, or "
                "the poses do not fit; scan.inspect detects wrong units");
        return made;
    }

    void color(Mesh& made, const std::vector<const Frame*>& measured, DepthPictures& depths, RunContext& run) const
    {
        fuse::VertexColors colors(made, truncation());
        each_batch<fuse::ColorView>(
            measured, 2, run,
            [&](const Frame& frame) {
                return fuse::ColorView{frame.depth, depths.of(frame), frame.color, load_color(frame, codec())};
            },
            [&](std::vector<fuse::ColorView>& views, std::size_t) { colors.add(views, run); });
        made.colors = colors.colors();
    }

    /// Wrong conventions of poses would fuse into a heap, or paint the given mesh with the wrong pictures. Without depth, edges
    /// of the color pictures are compared with the mesh's outlines.
    void compare_poses(DepthPictures& depths, RunContext& run) const
    {
        std::optional<raycast::Scene> cast;
        if (given.has_value())
        {
            check_mesh(*given, "the mesh on port 'mesh'");
            cast.emplace(*given);
        }
        const raycast::Scene* const scene = cast ? &*cast : nullptr;
        Frames comparable = *frames;
        std::erase_if(comparable.frames, [](const Frame& frame) { return frame.depth_picture.empty(); });
        if (comparable.frames.empty())
            comparable = *frames;
        const auto depth = [&](const Frame& frame) { return depths.of(frame); };
        std::vector<inspect::View> views;
        for (const inspect::Chosen& chosen : inspect::chosen_frames(comparable, checked_frames, given.has_value(), depth))
        {
            run.check_canceled();
            const bool with_color = comparable.frames[chosen.frame].depth_picture.empty();
            views.push_back(inspect::view_of(comparable, chosen, depth, codec(), with_color));
        }
        const auto agreements = agreements_of(scene, views, false);
        inspect::Agreement sum = inspect::total(agreements);
        if (sum.share() < doubtful_share)
        {
            const inspect::Agreement fused = inspect::total(agreements_of(scene, views, true));
            if (fused.covered() >= fewest_compared_depths && fused.share() >= doubtful_share)
                sum = fused;
        }
        if (sum.samples > 0)
            run.report("agreement", sum.share());
        if (sum.share() < doubtful_share && (given.has_value() || views.size() > 1))
            tell(inspect::diagnose(scene, views, run), agreements, run);
    }

    /// `fused_only`: without depths that the stage ignores. Their noise is no reason to doubt the poses, but wrong units put all
    /// depths there.
    std::vector<inspect::Agreement> agreements_of(const raycast::Scene* scene, const std::vector<inspect::View>& views,
                                                  bool fused_only) const
    {
        std::vector<inspect::DepthView> depths;
        for (const inspect::View& view : views)
        {
            depths.push_back(view.depth);
            if (fused_only)
                std::erase_if(depths.back().samples, [&](const inspect::DepthSample& sample)
                              { return static_cast<double>(sample.depth) > *max_depth_m; });
        }
        return inspect::agreement(inspect::depth_ratios(scene, depths, {}, 1), 1);
    }

    void tell(const inspect::Diagnosis& found, const std::vector<inspect::Agreement>& agreements, RunContext& run) const
    {
        const inspect::Agreement sum = inspect::total(agreements);
        const auto overlapping = std::ranges::count_if(agreements, [](const inspect::Agreement& frame)
                                                       { return frame.covered() >= fewest_depths_of_frame; });
        const bool is_explained = found.assumption != inspect::Assumption{};
        const bool is_empty = !found.findings.empty() && found.findings.front().cause == "empty_depth";
        bool is_certain = false;
        std::string text;
        for (const inspect::Finding& finding : found.findings)
        {
            text += (text.empty() ? "" : "; ") + finding.text;
            // Without depth, what is said of the color camera is no reason to stop.
            is_certain |= finding.certain && (sum.samples > 0 || is_explained || finding.cause == "equal_poses");
        }
        const bool overlap = overlapping >= fewest_overlapping_frames && sum.covered() >= fewest_compared_depths &&
                             sum.in_front > inspect::hardly_in_front * sum.covered();
        // The extraction refuses frames of which all the others are empty, too.
        if (!given.has_value() && is_empty)
            return run.warning(text);
        if (!given.has_value() && !overlap && !(is_explained && is_certain))
            return run.message("depth pictures overlap too little to tell whether the poses are right");
        if (is_certain && sum.share() < wrong_share)
            throw Error(given.has_value()
                            ? "the frames contradict the mesh on port 'mesh': " + text +
                                  "; if the mesh was edited on purpose, set check_poses: false"
                            : "the recording contradicts itself: " + text + ". To continue anyway, set check_poses: false");
        if (!text.empty())
            run.warning(text);
    }

    Mesh closed(const Mesh& mesh_with_holes, const std::vector<const Frame*>& measured, DepthPictures& depths,
                RunContext& run) const
    {
        return holes->closed(
            mesh_with_holes, measured, [&](const Frame& frame) { return depths.of(frame); }, run);
    }

    void run(RunContext& run) override
    {
        run.report("fused", !given.has_value());
        if (*voxel_m > 0 && *voxel_m < least_voxel_m)
            throw Error(fmt::format("option \"voxel_m\" is {:g}; expected 0 or at least {:g}", *voxel_m, least_voxel_m));
        if (given.has_value())
            check_offset(*frames, *given);
        const std::vector<const Frame*> measured = frames_with_depth();
        if (!given.has_value() && measured.empty())
            throw Error("no frame on port 'frames' has a depth picture: use a scan with depth, or wire a mesh to port 'mesh'");
        if (const std::size_t lost = frames->frames.size() - measured.size(); !given.has_value() && lost > 0)
            run.warning(fmt::format("{} of {} frames have no depth picture and are left out", lost, frames->frames.size()));
        DepthPictures depths(codec(), limit_bytes() / 4);
        if (*check_poses && !frames->frames.empty())
            compare_poses(depths, run);
        if (given.has_value())
        {
            run.message(fmt::format("the recording has a mesh of {} faces: it is passed on", given->triangles.size()));
            if (holes.has_value())
            {
                check_mesh(*given, "the mesh on port 'mesh'");
                mesh = closed(*given, measured, depths, run);
                return;
            }
            Mesh passed = *given;
            passed.saved_in = given.folder();
            mesh = std::move(passed);
            return;
        }
        voxel_ = *voxel_m > 0 ? *voxel_m : voxel_by_pixels(measured, depths, run);
        Mesh made = extract(fuse_frames(measured, depths, run), run);
        color(made, measured, depths, run);
        made.offset_m = frames->offset_m;
        check_mesh(made, "the fused mesh");
        run.report("frames", measured.size());
        run.report("depth_bytes", depths.bytes());
        run.report("faces", made.triangles.size());
        run.report("vertices", made.positions.size());
        mesh = holes.has_value() ? closed(made, measured, depths, run) : std::move(made);
    }
};

}  // namespace

FRESCO_STAGE("mesh.fuse", MeshFuse, "Fuses depth pictures into a mesh, or passes on the one there is")
FRESCO_LIBRARY("Embree", raycast::embree_version())
