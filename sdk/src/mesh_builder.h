#pragma once

#include <fresco/mesh_io.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fresco::detail
{

enum class DegenerateFaces
{
    drop,
    keep
};

/// Cuts polygons into fans of triangles and counts what had to be changed. Its callers check indices and limits.
class TriangleFan
{
  public:
    TriangleFan(MeshReadReport& report, DegenerateFaces degenerate) : report_(report), degenerate_(degenerate) {}

    /// Calls `triangle(a, b, c)` with positions into `corners`, which holds three vertex indices or more.
    template <class F>
    void split(std::span<const std::uint32_t> corners, F&& triangle)
    {
        if (corners.size() > 3)
            ++report_.polygons_split;
        for (std::size_t i = 2; i < corners.size(); ++i)
        {
            const std::uint32_t a = corners[0];
            const std::uint32_t b = corners[i - 1];
            const std::uint32_t c = corners[i];
            if (degenerate_ == DegenerateFaces::drop && (a == b || b == c || c == a))
                ++report_.degenerate_dropped;
            else
                triangle(std::size_t{0}, i - 1, i);
        }
    }

  private:
    MeshReadReport& report_;
    DegenerateFaces degenerate_;
};

/// parse_ply with a choice: the store's own files keep faces that name a vertex twice, so that face numbers stay what they were.
/// `materials`: empty, or null if the caller wants none.
Mesh parse_ply_faces(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
                     DegenerateFaces degenerate, MeshMaterials* materials = nullptr, PlyIntegers* integers = nullptr);

}  // namespace fresco::detail
