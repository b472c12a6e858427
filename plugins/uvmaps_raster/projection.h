#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/uv_mapping/into_camera.h>

#include <cstdint>
#include <vector>

namespace raster
{

/// What lies nearer to the camera's plane than this, meters, is cut away: a hundredth of a millimeter.
inline constexpr double near_m = 1e-5;

/// A point as the camera sees it, for any size of its pictures.
struct Projected
{
    double x = 0;            ///< X / Z in the camera, …
    double y = 0;            ///< … and Y / Z; 0 where `sides` says that it needs clipping.
    float nearness = 0;      ///< 1 / Z, per meter.
    std::uint8_t sides = 0;  ///< Of which planes it lies on the far side.
};

/// The planes about what a camera sees: through its center and the picture's borders; the plane near_m before it; and planes
/// through the center a picture's size beyond the borders, between which coordinates stay small.
struct Frustum
{
    static constexpr std::uint8_t left = 1;
    static constexpr std::uint8_t right = 2;
    static constexpr std::uint8_t above = 4;
    static constexpr std::uint8_t below = 8;
    static constexpr std::uint8_t behind = 16;
    static constexpr std::uint8_t far_aside = 32;

    /// Bounds of X / Z and Y / Z.
    struct Box
    {
        double left, right, above, below;
    };
    Box picture;
    Box guard;

    explicit Frustum(const fresco::Intrinsics& intrinsics);

    /// `point`: in the camera's frame.
    Projected project(fresco::Vec3d point) const;
};

/// What lies wholly beyond one plane is not seen.
inline bool out_of_sight(std::uint8_t a, std::uint8_t b, std::uint8_t c)
{
    return (a & b & c & ~Frustum::far_aside) != 0;
}
inline bool needs_clipping(std::uint8_t a, std::uint8_t b, std::uint8_t c)
{
    return ((a | b | c) & (Frustum::behind | Frustum::far_aside)) != 0;
}

/// The vertices of a mesh. Shared among progress.threads() threads. Throws Canceled.
void project_all(const std::vector<fresco::Vec3f>& positions, const fresco::IntoCamera& into_camera, const Frustum& frustum,
                 const fresco::Progress& progress, std::vector<Projected>& projected);

}  // namespace raster
