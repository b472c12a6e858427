#pragma once

#include "quadratic.h"

#include <fresco/mesh.h>

#include <cstdint>
#include <vector>

/// What a vertex carries in addition to its position.
struct VertexLoad
{
    fresco::Vec3f normal;  ///< Sum of area vectors of the faces it came from: what outside was.
    fresco::Vec3f color;   ///< Mean over `area`, 0..255.
    float area = 0;
};

/// A part of a surface with the connectivity that collapses need: half h = 4 f + k runs from corner k of face f to the next
/// corner and has the face on its left. A manifold: at most two faces an edge, one fan a vertex. Not safe for two threads at a
/// time.
class Piece
{
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    /// The first `frozen` vertices stay: faces outside of the piece share them, and their fans may be incomplete here.
    Piece(std::vector<fresco::Vec3f> positions, std::vector<VertexLoad> loads, std::size_t frozen,
          const std::vector<fresco::Triangle>& faces);

    std::size_t halves() const { return from_.size(); }
    std::size_t vertices() const { return positions_.size(); }
    std::size_t faces() const { return faces_; }

    static std::uint32_t next(std::uint32_t h) { return (h & 3U) == 2 ? h - 2 : h + 1; }
    static std::uint32_t previous(std::uint32_t h) { return (h & 3U) == 0 ? h + 2 : h - 1; }
    bool alive(std::uint32_t h) const { return from_[h] != none; }
    std::uint32_t from(std::uint32_t h) const { return from_[h]; }
    std::uint32_t to(std::uint32_t h) const { return from_[next(h)]; }
    /// The other half of the edge; `none` at a border.
    std::uint32_t mate(std::uint32_t h) const { return mate_[h]; }
    bool frozen(std::uint32_t v) const { return v < frozen_; }
    fresco::Vec3f position(std::uint32_t v) const { return positions_[v]; }
    const VertexLoad& load(std::uint32_t v) const { return loads_[v]; }
    /// Counts the changes of the faces around a vertex.
    std::uint32_t version(std::uint32_t v) const { return versions_[v]; }

    /// The best replacement of an edge of free vertices.
    Placement placement(std::uint32_t h) const;
    /// Whether the surface stays a manifold of the same kind, and no face turns away, where the edge becomes `point`.
    bool allowed(std::uint32_t h, fresco::Vec3d point);
    /// Replaces an allowed edge by `point` (relative to `origin()`); its first vertex stays.
    void collapse(std::uint32_t h, fresco::Vec3d point);

    /// Calls visit(half) for the halves that leave v, counter-clockwise; all of them for vertices that are not frozen.
    template <class Visit>
    void around(std::uint32_t v, Visit visit) const
    {
        const std::uint32_t first = leaving_[v];
        for (std::uint32_t h = first;;)
        {
            visit(h);
            h = mate_[previous(h)];
            if (h == none || h == first)
                return;
        }
    }
    /// Points are relative to this.
    fresco::Vec3d origin() const { return origin_; }

  private:
    fresco::Vec3d relative(std::uint32_t v) const { return fresco::vec_cast<double>(positions_[v]) - origin_; }
    Quadratic face_error(std::uint32_t h) const;
    bool border(std::uint32_t v) const { return mate_[leaving_[v]] == none; }
    std::uint32_t last_around(std::uint32_t v) const;
    bool keeps_topology(std::uint32_t h);
    bool keeps_outside(std::uint32_t h, fresco::Vec3d point) const;
    void add_border(std::uint32_t v, std::uint32_t but, Quadratic& sum) const;
    void glue(std::uint32_t a, std::uint32_t b);
    void turn_to_border(std::uint32_t v, std::uint32_t leaving);

    std::vector<fresco::Vec3f> positions_;
    std::vector<VertexLoad> loads_;
    std::size_t frozen_;
    fresco::Vec3d origin_;
    std::vector<std::uint32_t> from_;     ///< By half; `none` for all of a removed face.
    std::vector<std::uint32_t> mate_;     ///< By half.
    std::vector<std::uint32_t> leaving_;  ///< By vertex: a half that leaves it; the border's, if it is on one.
    std::vector<Quadratic> errors_;       ///< By vertex: of the faces around.
    std::vector<std::uint32_t> versions_;
    std::vector<std::uint32_t> marks_;
    std::uint32_t mark_ = 0;
    std::size_t faces_ = 0;
};
