#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/stage.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/uv_mapping/uv_mapper.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <utility>

using namespace fresco;

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

/// The sums over all maps.
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

/// The mesh with separate vertices for each face, whose normals are the face's.
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

class UvmapsRaster final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "Triangle mesh with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The views; their color cameras and masks are used"};
    Output<UvMaps> uvmaps{this, "uvmaps", "Per pixel: texcoord, depth, cosine of the viewing angle, validity"};
    Option<std::vector<int>> heights_px{this, "heights_px", {256}, range(16, 4096), "Heights of the maps; widths follow"};
    enum class Normals
    {
        smooth,
        face
    };
    Choice<Normals> normals{
        this,
        "normals",
        Normals::smooth,
        {{"smooth", Normals::smooth}, {"face", Normals::face}},
        "Normals that angles are measured from: of the vertices, interpolated, or of the faces, as StyleMesh's "
        "released renderer for ScanNet has them"};

    void run(RunContext& run) override
    {
        check_uv_mapping_inputs(*mesh, *frames);
        texturing::check_layout(*mesh, "the mesh on port 'mesh'", run);
        const std::vector<int> heights = sorted_heights(*heights_px);
        const Mesh separate = *normals == Normals::face ? with_separate_faces(*mesh) : Mesh{};
        UvMapper mapper(*normals == Normals::face ? separate : *mesh, std::make_unique<rendering::RasterFinder>(*mesh));
        const std::size_t count = frames->frames.size();

        const KeptPieces kept(run);

        UvMaps result;
        result.atlas = atlas_id(*mesh);
        result.texture_px = mesh->texture_px;
        result.uv_bits = uv_bits_for_texture(std::max(mesh->texture_px, 1));
        result.heights_px = heights;
        Tally tally;
        std::size_t found = 0;
        for (std::size_t i = 0; i < count; ++i)
        {
            run.check_canceled();
            const Frame& frame = frames->frames[i];
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
            run.progress(static_cast<double>((i + 1) * heights.size()), static_cast<double>(count * heights.size()), "maps");
        }
        if (found > 0)
            run.message(fmt::format("the maps of {} of {} frames were there from an interrupted run", found, count));
        for (std::size_t i = 0; i < count; ++i)
            kept.link(map_names(i, heights), uvmaps.folder().path);
        tally.tell(run);
        uvmaps = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("uvmaps.raster", UvmapsRaster, "Renders the mesh for the color cameras: uv, depth and angle per pixel")
