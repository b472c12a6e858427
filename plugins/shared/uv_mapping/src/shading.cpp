#include "shading_kernel.h"

#include <fresco/parallel.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <algorithm>
#include <limits>

namespace fresco
{

Sight sight(bool front, double depth)
{
    if (!front)
        return Sight::back_face;
    return depth < nearest_surface_m ? Sight::too_near : Sight::surface;
}

bool seen_through_crack(const RasterF& met, int x, int y)
{
    if (x < 1 || y < 1 || x + 1 >= met.width || y + 1 >= met.height)
        return false;
    const float depth = met.at(x, y);
    if (!(depth < std::numeric_limits<float>::infinity()))
        return false;
    const auto before = [&](int dx, int dy) { return depth > met.at(x + dx, y + dy) + crack_depth_m; };
    // The left one first: it answers for nearly every pixel.
    return before(-1, 0) && before(1, 0) && before(-1, -1) && before(0, -1) && before(1, -1) && before(-1, 1) && before(0, 1) &&
           before(1, 1);
}

namespace
{

struct alignas(64) CacheLine
{
    std::byte bytes[64];
};

constexpr int pixels_at_once = 16;

/// Whether one of so many pixels may be seen through a crack, by its neighbors in the row: rare, and cheap to find out.
bool any_behind_both(const float* met)
{
    int any = 0;
    for (int i = 0; i < pixels_at_once; ++i)
        any |= static_cast<int>(met[i] > met[i - 1] + crack_depth_m) & static_cast<int>(met[i] > met[i + 1] + crack_depth_m);
    return any != 0;
}

void clear_pixel(UvMap& map, std::size_t i)
{
    map.uv.values[2 * i] = map.uv.values[2 * i + 1] = 0;
    map.depth.values[i] = 0;
    map.cosine.values[i] = 0;
    map.valid.values[i] = 0;
}

}  // namespace

PixelCounts& PixelCounts::operator+=(const PixelCounts& other)
{
    return *this = {valid + other.valid, back_face + other.back_face, too_near + other.too_near,
                    crack + other.crack, nothing + other.nothing,     masked + other.masked};
}

const shading::Kernel& shading::fastest_kernel()
{
    static const auto& fastest = fastest_of(avx512_kernel(), avx2_kernel(), base_kernel());
    return fastest;
}

FaceShader::FaceShader(const Mesh& mesh) : FaceShader(mesh, shading::fastest_kernel()) {}

FaceShader::FaceShader(const Mesh& mesh, const shading::Kernel& kernel) : mesh_(mesh), kernel_(kernel)
{
    const auto normals = vertex_normals(mesh);
    vertices_.reserve(normals.size());
    for (std::size_t v = 0; v < normals.size(); ++v)
    {
        const Vec3f p = mesh.positions[v];
        const Vec3f n = normals[v];
        vertices_.push_back({{p.x, p.y, p.z}, {n.x, n.y, n.z}, {}});
    }
}

FaceShader::~FaceShader() = default;

PixelCounts FaceShader::shade(const Camera& camera, const FaceMap& faces, int first_row, int end_row, UvMap& map,
                              RasterF& met) const
{
    static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t) && sizeof(Vec2f) == 2 * sizeof(float));
    const Vec3d origin = camera.world_from_camera.translation;
    const Vec3d axis = IntoCamera(camera.world_from_camera).depth_axis();
    const Vec3d across = camera.world_from_camera.direction({1 / camera.intrinsics.fx, 0, 0});
    const shading::Source source{reinterpret_cast<const std::uint32_t(*)[3]>(mesh_.triangles.data()),
                                 reinterpret_cast<const float(*)[2]>(mesh_.texcoords.data()),
                                 vertices_.data(),
                                 {origin.x, origin.y, origin.z},
                                 {axis.x, axis.y, axis.z},
                                 {across.x, across.y, across.z},
                                 static_cast<float>(nearest_surface_m)};
    const auto width = static_cast<std::size_t>(faces.width);
    std::vector<CacheLine> scratch((width * kernel_.scratch_bytes + sizeof(CacheLine) - 1) / sizeof(CacheLine));
    shading::Seen seen{};
    for (int y = first_row; y < end_row; ++y)
    {
        const Vec3d first = camera.ray(0.5, y + 0.5);
        const double ray[3] = {first.x, first.y, first.z};
        const std::size_t i = faces.index(0, y);
        kernel_.shade_row(source, faces.values.data() + i, faces.width, ray,
                          {map.uv.values.data() + 2 * i, map.depth.values.data() + i, map.cosine.values.data() + i,
                           map.valid.values.data() + i, met.values.data() + i},
                          scratch.data(), seen);
    }
    return {seen.surface, seen.back_face, seen.too_near, 0, seen.nothing, 0};
}

std::int64_t FaceShader::close_cracks(const RasterF& met, int first_row, int end_row, UvMap& map)
{
    std::int64_t closed = 0;
    const auto close = [&](int x, int y)
    {
        if (map.valid.at(x, y) == 0 || !seen_through_crack(met, x, y))
            return;
        clear_pixel(map, map.valid.index(x, y));
        ++closed;
    };
    for (int y = first_row; y < end_row; ++y)
        for (int x = 1; x < met.width; x += pixels_at_once)
            if (x + pixels_at_once >= met.width || any_behind_both(&met.at(x, y)))
                for (int i = x; i < std::min(x + pixels_at_once, met.width); ++i)
                    close(i, y);
    return closed;
}

std::int64_t FaceShader::apply_mask(const Raster8& mask, int first_row, int end_row, UvMap& map)
{
    if (mask.empty())
        return 0;
    std::int64_t ignored = 0;
    for (std::size_t i = mask.index(0, first_row); i < mask.index(0, end_row); ++i)
        if (mask.values[i] == 0 && map.valid.values[i] != 0)
        {
            clear_pixel(map, i);
            ++ignored;
        }
    return ignored;
}

}  // namespace fresco
