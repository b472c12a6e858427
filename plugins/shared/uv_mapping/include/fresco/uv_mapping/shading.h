#pragma once

/// \file From the face that each pixel sees to the values of its uv map, and the pixels that see none well: what a ray ends on,
/// cracks of the mesh, masks. For uv_mapper.h; Sight also for those who cast rays.

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/uv_maps.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace fresco
{

/// Nearer surfaces are the scanner's own noise, not something a camera saw.
inline constexpr double nearest_surface_m = 0.05;

/// End of a camera's ray.
enum class Sight
{
    nothing,
    surface,    ///< The front of a face, at least nearest_surface_m away.
    back_face,  ///< The back of a face: nothing behind it is seen either.
    too_near    ///< The front of a face nearer than nearest_surface_m along the optical axis.
};

/// Judges what was met at a depth (meters along the optical axis).
Sight sight(bool front, double depth);

/// How far behind all its neighbors a pixel lies that was seen through a crack of the mesh.
inline constexpr float crack_depth_m = 0.05F;

/// Whether the pixel lies more than crack_depth_m behind each of its eight neighbors. `met`: H x W, the depth of what each
/// pixel's ray meets first, whichever side of whatever it is; infinity where it meets nothing. A pixel at the border of the
/// picture has no eight neighbors, one that met nothing lies behind nothing: false.
bool seen_through_crack(const RasterF& met, int x, int y);

/// H x W: the face (its index in the mesh) that each pixel center's ray meets first, or no_face.
using FaceMap = Raster<std::uint32_t>;
inline constexpr std::uint32_t no_face = std::numeric_limits<std::uint32_t>::max();

/// Counts of a map's pixels by their fate; the six sum to width x height.
struct PixelCounts
{
    std::int64_t valid = 0;
    std::int64_t back_face = 0;
    std::int64_t too_near = 0;
    std::int64_t crack = 0;
    std::int64_t nothing = 0;
    std::int64_t masked = 0;  ///< The front of the mesh is seen, but the mask ignores the pixel.

    PixelCounts& operator+=(const PixelCounts& other);
    friend bool operator==(const PixelCounts&, const PixelCounts&) = default;
};

namespace shading
{
struct Kernel;
struct Vertex;
}  // namespace shading

/// Texcoord, depth and angle of the faces that pixels see, from the mesh itself: where a ray meets a face in double precision,
/// what the face has there in single.
class FaceShader
{
  public:
    /// The mesh needs texcoords, must have passed check_mesh and must outlive the shader. Keeps 32 bytes per vertex.
    explicit FaceShader(const Mesh& mesh);
    /// Shades by the loops for one kind of processor.
    FaceShader(const Mesh& mesh, const shading::Kernel& kernel);
    ~FaceShader();
    FaceShader(const FaceShader&) = delete;
    FaceShader& operator=(const FaceShader&) = delete;

    /// Fills rows [first_row, end_row) of `map` and of `met`, both of the size of `faces`. Per pixel the texcoord (correct in
    /// perspective) where its ray meets the face's plane, the depth along the optical axis and the cosine between the smooth
    /// vertex normal (area-weighted) and the direction to the camera; zeros where it is not valid (see Sight). A ray that passes
    /// by its face, for rounding or because the face has no area, gets the face's nearest point; never a NaN. `met`: as
    /// seen_through_crack takes it. `camera` has the map's size. Thread-safe for different rows.
    PixelCounts shade(const Camera& camera, const FaceMap& faces, int first_row, int end_row, UvMap& map, RasterF& met) const;

    /// Takes the valid pixels of rows [first_row, end_row) that were seen through a crack out of the map, and returns their
    /// number. `met` is complete. Thread-safe for different rows.
    static std::int64_t close_cracks(const RasterF& met, int first_row, int end_row, UvMap& map);

    /// Takes the valid pixels of rows [first_row, end_row) that a mask of the map's size ignores out of the map, and returns
    /// their number. Thread-safe for different rows.
    static std::int64_t apply_mask(const Raster8& mask, int first_row, int end_row, UvMap& map);

  private:
    const Mesh& mesh_;
    const shading::Kernel& kernel_;
    std::vector<shading::Vertex> vertices_;
};

}  // namespace fresco
