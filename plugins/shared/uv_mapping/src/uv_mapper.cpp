#include <fresco/error.h>
#include <fresco/parallel.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace fresco
{
namespace
{

constexpr int rows_per_block = 16;

template <class T>
void set_size(Raster<T>& raster, int width, int height, int channels = 1)
{
    if (raster.width != width || raster.height != height)
        raster = Raster<T>(width, height, channels);
}

}  // namespace

FaceFinder::~FaceFinder() = default;

UvMapper::UvMapper(const Mesh& mesh, std::unique_ptr<FaceFinder> finder) : shader_(mesh), finder_(std::move(finder)) {}

void UvMapper::resize(const Camera& camera, std::span<const int> heights_px)
{
    cameras_.assign(heights_px.size(), camera);
    faces_.resize(heights_px.size());
    met_.resize(heights_px.size());
    maps_.resize(heights_px.size());
    blocks_.clear();
    for (std::size_t i = 0; i < heights_px.size(); ++i)
    {
        const int height = heights_px[i];
        const int width = camera.intrinsics.width_at(height);
        cameras_[i].intrinsics = camera.intrinsics.scaled_to(width, height);
        set_size(faces_[i], width, height);
        set_size(met_[i], width, height);
        UvMap& map = maps_[i].map;
        set_size(map.uv, width, height, 2);
        set_size(map.depth, width, height);
        set_size(map.cosine, width, height);
        set_size(map.valid, width, height);
        for (int row = 0; row < height; row += rows_per_block)
            blocks_.push_back({i, row, std::min(row + rows_per_block, height)});
    }
    block_counts_.resize(blocks_.size());
}

const std::vector<CountedUvMap>& UvMapper::make(const Camera& camera, std::span<const int> heights_px, const Progress& progress,
                                                const Raster8& mask)
{
    resize(camera, heights_px);
    std::vector<Raster8> masks;
    for (const Camera& scaled : cameras_)
        masks.push_back(mask_at(mask, scaled.intrinsics.width, scaled.intrinsics.height));
    finder_->find(cameras_, progress, faces_);
    const auto for_each_block = [&](const auto& work)
    { parallel_items(blocks_.size(), 1, progress, [&](std::size_t block) { work(blocks_[block], block_counts_[block]); }); };
    for_each_block(
        [&](const Rows& rows, PixelCounts& counts) {
            counts =
                shader_.shade(cameras_[rows.map], faces_[rows.map], rows.first, rows.end, maps_[rows.map].map, met_[rows.map]);
        });
    for_each_block(
        [&](const Rows& rows, PixelCounts& counts)
        {
            counts.crack = FaceShader::close_cracks(met_[rows.map], rows.first, rows.end, maps_[rows.map].map);
            counts.masked = FaceShader::apply_mask(masks[rows.map], rows.first, rows.end, maps_[rows.map].map);
            counts.valid -= counts.crack + counts.masked;
        });
    for (CountedUvMap& map : maps_)
        map.counts = {};
    for (std::size_t block = 0; block < blocks_.size(); ++block)
        maps_[blocks_[block].map].counts += block_counts_[block];
    return maps_;
}

void check_viewed(const Mesh& mesh, const Frames& frames, std::string_view wire)
{
    check_mesh(mesh, "the mesh on port 'mesh'");
    check_offset(frames, mesh);
    if (mesh.texcoords.empty())
        throw Error(fmt::format("the mesh on port 'mesh' has no texcoords: wire {}", wire));
    if (frames.frames.empty())
        throw Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
    for (const Frame& frame : frames.frames)
        check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
}

void check_uv_mapping_inputs(const Mesh& mesh, const Frames& frames)
{
    check_viewed(mesh, frames, "an atlas.* stage");
    // A packed map takes as much for rounding.
    const auto within = [](float share) { return share >= -1e-5F && share <= 1 + 1e-5F; };
    const auto outside = [&](const Vec2f& texcoord) { return !within(texcoord.x) || !within(texcoord.y); };
    if (const auto bad = std::ranges::find_if(mesh.texcoords, outside); bad != mesh.texcoords.end())
        throw Error(fmt::format("face {} of the mesh on port 'mesh' has texcoords outside [0,1]: wire an atlas.* stage",
                                (bad - mesh.texcoords.begin()) / 3));
}

}  // namespace fresco
