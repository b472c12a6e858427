#include <fresco/parallel.h>
#include <fresco/run_context.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <utility>

namespace fresco
{
namespace
{

std::vector<int> sorted_heights(std::vector<int> heights)
{
    std::sort(heights.begin(), heights.end());
    if (heights.empty())
        throw Error("option \"heights_px\" is empty; set at least one height, such as [256]");
    if (const auto twice = std::adjacent_find(heights.begin(), heights.end()); twice != heights.end())
        throw Error(fmt::format("option \"heights_px\" has {} twice; set each height once", *twice));
    return heights;
}

/// What all maps together came to.
class Tally
{
  public:
    void add(const Frame& frame, const std::vector<PixelCounts>& maps)
    {
        ++frames_;
        maps_ += maps.size();
        bool sees = false;
        for (const PixelCounts& counts : maps)
        {
            pixels_ += counts;
            sees = sees || counts.valid > 0;
        }
        if (!sees && blind_++ == 0)
            first_blind_ = frame.sequence + "/" + frame.name;
    }

    void tell(RunContext& run) const
    {
        run.report("maps", maps_);
        run.report("valid_pixels", pixels_.valid);
        run.report("back_face_pixels", pixels_.back_face);
        run.report("too_near_pixels", pixels_.too_near);
        run.report("crack_pixels", pixels_.crack);
        run.report("empty_pixels", pixels_.nothing);
        run.report("masked_pixels", pixels_.masked);
        run.report("blind_frames", blind_);
        if (blind_ == 0)
            return;
        run.warning(fmt::format(
            "{} of {} frames do not see the front of the mesh, first {}{}", blind_, frames_, first_blind_,
            blind_ == frames_
                ? ": check that mesh and poses share one world frame and that faces are counter-clockwise from outside"
                : ""));
    }

  private:
    PixelCounts pixels_;
    std::size_t maps_ = 0;
    std::size_t frames_ = 0;
    std::size_t blind_ = 0;
    std::string first_blind_;
};

/// The files of a view as UvMaps documents them.
std::vector<std::string> map_names(std::size_t view, const std::vector<int>& heights)
{
    std::vector<std::string> names;
    for (const int height : heights)
        names.push_back(fmt::format("{:06}_{}.uvmap", view, height));
    return names;
}

/// The same faces, none of which shares a vertex with another: the normals of its vertices are the face's.
Mesh with_separate_faces(const Mesh& mesh)
{
    Mesh separate;
    separate.texcoords = mesh.texcoords;
    for (const Triangle& face : mesh.triangles)
    {
        const auto first = static_cast<std::uint32_t>(separate.positions.size());
        separate.triangles.push_back({first, first + 1, first + 2});
        for (const auto vertex : face)
            separate.positions.push_back(mesh.positions[vertex]);
    }
    return separate;
}

Value to_value(const std::vector<PixelCounts>& maps)
{
    Value::List list;
    for (const PixelCounts& c : maps)
        list.emplace_back(Value::List{c.valid, c.back_face, c.too_near, c.crack, c.nothing, c.masked});
    return list;
}

std::vector<PixelCounts> counts_from(const Value& value)
{
    std::vector<PixelCounts> maps;
    for (const Value& counts : value.as_list())
    {
        PixelCounts& c = maps.emplace_back();
        std::size_t next = 0;
        for (std::int64_t* const count : {&c.valid, &c.back_face, &c.too_near, &c.crack, &c.nothing, &c.masked})
            *count = counts.as_list().at(next++).as_int();
    }
    return maps;
}

}  // namespace

void check_uv_mapping_inputs(const Mesh& mesh, const Frames& frames)
{
    check_mesh(mesh, "the mesh on port 'mesh'");
    if (mesh.texcoords.empty())
        throw Error("the mesh on port 'mesh' has no texcoords: wire an atlas.* stage");
    // What a packed map takes for rounding.
    const auto within = [](float share) { return share >= -1e-5F && share <= 1 + 1e-5F; };
    const auto outside = [&](const Vec2f& texcoord) { return !within(texcoord.x) || !within(texcoord.y); };
    if (const auto bad = std::ranges::find_if(mesh.texcoords, outside); bad != mesh.texcoords.end())
        throw Error(fmt::format("face {} of the mesh on port 'mesh' has texcoords outside [0,1]: wire an atlas.* stage",
                                (bad - mesh.texcoords.begin()) / 3));
    if (frames.frames.empty())
        throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
    for (const Frame& frame : frames.frames)
        check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
}

void UvMappingStage::run(RunContext& run)
{
    check_uv_mapping_inputs(*mesh_, *frames_);
    texturing::check_layout(*mesh_, "the mesh on port 'mesh'", run);
    const std::vector<int> heights = sorted_heights(*heights_px_);
    const Mesh separate = *normals_ == Normals::face ? with_separate_faces(*mesh_) : Mesh{};
    UvMapper mapper(*normals_ == Normals::face ? separate : *mesh_, finder(*mesh_, run));
    const std::size_t frames = frames_->frames.size();

    const KeptPieces kept(run);

    UvMaps result;
    result.atlas = atlas_id(*mesh_);
    result.texture_px = mesh_->texture_px;
    result.uv_bits = uv_bits_for_texture(std::max(mesh_->texture_px, 1));
    result.heights_px = heights;
    Tally tally;
    std::size_t found = 0;
    for (std::size_t i = 0; i < frames; ++i)
    {
        run.check_canceled();
        const Frame& frame = frames_->frames[i];
        std::vector<PixelCounts> counts;
        if (const auto earlier = kept.find(i))
        {
            counts = counts_from(*earlier);
            ++found;
        }
        else
        {
            const auto& maps = mapper.make(frame.color, heights, run, load_mask(frame));
            parallel_for(heights.size(), 1, run,
                         [&](std::size_t level, std::size_t) {
                             UvMaps::write_map({kept.folder(), {}}, i, heights[level], maps[level].map, result.uv_bits);
                         });
            for (const CountedUvMap& map : maps)
                counts.push_back(map.counts);
            kept.note(i, map_names(i, heights), to_value(counts));
        }
        UvMaps::View view{frame.sequence, frame.name, frame.color, {}};
        for (const PixelCounts& map : counts)
            view.valid_pixels.push_back(map.valid);
        result.views.push_back(std::move(view));
        tally.add(frame, counts);
        run.progress(static_cast<double>((i + 1) * heights.size()), static_cast<double>(frames * heights.size()), "maps");
    }
    if (found > 0)
        run.message(fmt::format("the maps of {} of {} frames were there from an interrupted run", found, frames));
    for (std::size_t i = 0; i < frames; ++i)
        kept.link(map_names(i, heights), uvmaps_.folder().path);
    tally.tell(run);
    uvmaps_ = std::move(result);
}

}  // namespace fresco
