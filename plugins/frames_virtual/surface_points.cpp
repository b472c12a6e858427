#include "surface_points.h"

#include <fresco/mesh.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/uv_mapping/sight.h>

#include <algorithm>
#include <array>

namespace fresco::virtual_views
{
namespace
{

constexpr double tolerance_m = 1e-3;

/// Up to packet_size points, looked at together.
class Batch
{
  public:
    Batch(const raycast::Scene& scene, std::span<const SurfacePoint> points, Vec3d eye, std::vector<std::uint32_t>& seen)
        : scene_(scene), points_(points), eye_(eye), seen_(seen)
    {
    }

    void add(std::uint32_t number, Vec3d toward)
    {
        numbers_[count_] = number;
        directions_[count_++] = toward;
        if (count_ == numbers_.size())
            look();
    }

    void look()
    {
        scene_.cast(eye_, std::span(directions_).first(count_), std::span(hits_).first(count_));
        for (std::size_t i = 0; i < count_; ++i)
        {
            const raycast::Hit& hit = hits_[i];
            const bool there = hit.found() && hit.front && (1 - hit.distance) * length(directions_[i]) <= tolerance_m;
            if (there || hit.triangle == points_[numbers_[i]].face)
                seen_.push_back(numbers_[i]);
        }
        count_ = 0;
    }

  private:
    const raycast::Scene& scene_;
    std::span<const SurfacePoint> points_;
    Vec3d eye_;
    std::vector<std::uint32_t>& seen_;
    std::array<std::uint32_t, raycast::Scene::packet_size> numbers_{};
    std::array<Vec3d, raycast::Scene::packet_size> directions_{};
    std::array<raycast::Hit, raycast::Scene::packet_size> hits_{};
    std::size_t count_ = 0;
};

}  // namespace

std::vector<SurfacePoint> surface_points(const Mesh& mesh, int cells_px, const Progress& progress)
{
    const auto charts = texturing::find_charts(mesh);
    const auto faces = texturing::find_texel_faces(mesh, charts, cells_px, progress);
    const auto normals = face_normals(mesh);
    std::vector<SurfacePoint> points;
    for (std::size_t cell = 0; cell < faces.face.size(); ++cell)
        if (faces.inside[cell] != 0)
            points.push_back({texturing::texel_position(mesh, faces, cell), normals[faces.face[cell]], faces.face[cell],
                              charts.of_face[faces.face[cell]], static_cast<std::uint32_t>(cell)});
    return points;
}

std::vector<std::uint32_t> visible_points(const raycast::Scene& scene, std::span<const SurfacePoint> points, Vec3d eye,
                                          std::span<const std::uint32_t> asked)
{
    std::vector<std::uint32_t> seen;
    Batch batch(scene, points, eye, seen);
    for (const std::uint32_t number : asked)
    {
        const Vec3d toward = vec_cast<double>(points[number].position) - eye;
        if (dot(vec_cast<double>(points[number].normal), toward) < 0 && length(toward) >= nearest_surface_m)
            batch.add(number, toward);
    }
    batch.look();
    return seen;
}

bool in_picture(const Camera& camera, const Raster8& mask, Vec3f position)
{
    const Vec3d at = camera.project(vec_cast<double>(position));
    const Intrinsics& size = camera.intrinsics;
    if (!(at.z > 0 && at.x >= 0 && at.y >= 0 && at.x < size.width && at.y < size.height))
        return false;
    return mask.empty() || mask.at(static_cast<int>(at.x), static_cast<int>(at.y)) != 0;
}

}  // namespace fresco::virtual_views
