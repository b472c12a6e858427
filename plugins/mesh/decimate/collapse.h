#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// \file Collapses the edges of one piece of a surface, cheapest first, into the points that change the surface least.
/// decimated() cuts a mesh into such pieces and runs an EdgeQueue on each, in parallel.
///
/// The cost of replacing an edge by a point is the sum of squared distances to the planes of the faces around, as they are now,
/// without memory of earlier collapses (Lindstrom and Turk, "Fast and memory efficient polygonal simplification", Visualization
/// 1998; Hoppe, "New quadric metric for simplifying meshes with appearance attributes", Visualization 1999, section 5). Points
/// are meters from an origin near the surface.

/// The quadratic xᵀHx - 2k·x + c.
struct Quadratic
{
    std::array<double, 6> h{};  ///< xx, xy, xz, yy, yz, zz.
    fresco::Vec3d k;
    double c = 0;

    double operator()(fresco::Vec3d x) const;
    void add(const Quadratic& other, double weight = 1)
    {
        for (std::size_t i = 0; i < h.size(); ++i)
            h[i] += weight * other.h[i];
        k += other.k * weight;
        c += weight * other.c;
    }
    double trace() const { return h[0] + h[3] + h[5]; }
};

/// Squared distance to a face's plane, times (twice the area)^1.25: between area, which serves the largest distances, and its
/// square, which serves the mean. Zero for a face without area.
Quadratic plane_error(fresco::Vec3d a, fresco::Vec3d b, fresco::Vec3d c);

/// Squared distance to the line of a border edge, times its squared length.
Quadratic line_error(fresco::Vec3d a, fresco::Vec3d b);

/// A point in place of an edge.
struct Placement
{
    fresco::Vec3d point;
    double cost = 0;  ///< >= 0; infinite if there is no point near the edge.
};

/// The best point for an edge from u to v: the least of `planes` (the sum over the faces around it) and of `lines` (over the
/// border edges around it; null: none). If these leave it free, near the middle of the edge.
Placement place(const Quadratic& planes, const Quadratic* lines, fresco::Vec3d u, fresco::Vec3d v);

/// Attributes of a vertex in addition to its position.
struct VertexLoad
{
    fresco::Vec3f normal;  ///< Sum of area vectors of the original faces: the original outside.
    fresco::Vec3f color;   ///< Mean over `area`, 0..255.
    float area = 0;
};

/// A piece of a surface with the connectivity that collapses need: half h = 4 f + k runs from corner k of face f to the next
/// corner and has the face on its left. A manifold: at most two faces an edge, one fan a vertex. Not safe for two threads at a
/// time.
class Piece
{
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    /// The first `frozen` vertices stay fixed: faces outside of the piece share them, and their fans may be incomplete here.
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
    /// Whether replacing the edge by `point` keeps the surface a manifold of the same kind, and turns no face over.
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

/// Collapses edges of a piece, cheapest first, up to a price that rises from call to call. Edges whose two faces a collapse
/// changed are repriced at once; those that only touch changed faces when their turn comes, because their prices mostly rise.
class EdgeQueue
{
  public:
    /// Prices every edge between free vertices. Keeps a reference to the piece.
    explicit EdgeQueue(Piece& piece);

    /// Removes up to `faces` faces (one more if the last collapse removes two) by collapses that cost at most `most`.
    /// Returns the number of removed faces.
    std::size_t run(float most, std::size_t faces);

    /// Calls visit(cost) for every waiting edge; for some more than once, with an earlier price.
    template <class Visit>
    void each_cost(Visit visit) const
    {
        for (const auto* entries : {&heap_, &later_})
            for (const Entry& entry : *entries)
                visit(entry.cost);
    }

  private:
    struct Entry
    {
        float cost;
        std::uint32_t half;
        std::uint32_t version;
    };
    static bool after(const Entry& a, const Entry& b) { return a.cost != b.cost ? a.cost > b.cost : a.half > b.half; }
    bool free(std::uint32_t h) const { return !piece_.frozen(piece_.from(h)) && !piece_.frozen(piece_.to(h)); }
    std::uint32_t version(std::uint32_t h) const { return piece_.version(piece_.from(h)) + piece_.version(piece_.to(h)); }
    void offer(std::uint32_t h);
    void admit(float most);
    void try_collapse(std::uint32_t h);

    Piece& piece_;
    float most_ = -1;
    std::vector<Entry> heap_;     ///< Cost at most `most_`.
    std::vector<Entry> later_;    ///< The more expensive ones, unordered.
    std::vector<float> offered_;  ///< By half: the price of its valid entry; negative: none.
};
