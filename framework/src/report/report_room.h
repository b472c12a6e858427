#pragma once

#include "report/report_model.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/texture.h>

#include <array>
#include <cstddef>
#include <vector>

namespace fresco::host
{

/// A mesh in 12 bytes per vertex and per face.
struct PackedRoom
{
    std::array<double, 3> low{};     ///< World position of (0, 0, 0).
    std::array<double, 3> extent{};  ///< World size of the range 0..65535.
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    /// Per vertex six uint16: x, y, z, 0, u, v, of which 65535 is the end of the range; then per face three uint32: vertices,
    /// counter-clockwise. Little-endian.
    std::vector<std::byte> bytes;
};

/// Corners of one vertex with one texcoord (to 1/65535) share a packed vertex. A position is moved by at most half of
/// extent/65535, a texcoord outside of [0, 1] to the border. The mesh must have passed check_mesh and have texcoords.
PackedRoom pack_room(const Mesh& mesh);

/// Which way is up, unit length: what the cameras' horizontal axes are most nearly perpendicular to, as recorders are held level
/// however far they look down. There must be frames.
Vec3d upwards(const Frames& frames);

/// {position, forward, up} of a camera.
Value pose_value(const Camera& camera);

/// The room of the page. `frames` may be null: where to stand at first. Throws Error where the mesh is larger than a page
/// should hold.
ReportRoom report_room(const std::string& stage, const TexturedMesh& mesh, const Frames* frames, const ImageIo& images);

}  // namespace fresco::host
