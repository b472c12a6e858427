#include "collapse.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <limits>

using fresco::Vec3d;
using fresco::Vec3f;

namespace
{

/// Weight of lines at borders against planes, high enough to keep borders from drifting.
constexpr double line_weight = 0.6;
/// Pull toward the middle, against the stiffness of the surface: decides only where the surface does not.
constexpr double pull_share = 1e-7;
/// A point farther than this many edge lengths from the middle is not used.
constexpr double farthest_lengths = 2;
/// Price of the length of an edge where the surface is flat and every point costs nothing.
constexpr double length_price = 1e-9;

/// The inverse of a symmetric matrix times its determinant.
struct Adjugate
{
    std::array<double, 6> m;
    double determinant;

    explicit Adjugate(const std::array<double, 6>& h)
        : m{h[3] * h[5] - h[4] * h[4], h[2] * h[4] - h[1] * h[5], h[1] * h[4] - h[2] * h[3],
            h[0] * h[5] - h[2] * h[2], h[1] * h[2] - h[0] * h[4], h[0] * h[3] - h[1] * h[1]},
          determinant(h[0] * m[0] + h[1] * m[1] + h[2] * m[2])
    {
    }
    Vec3d times(Vec3d v) const
    {
        return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z, m[2] * v.x + m[4] * v.y + m[5] * v.z};
    }
};

}  // namespace

double Quadratic::operator()(Vec3d x) const
{
    const double curved =
        x.x * (h[0] * x.x + 2 * (h[1] * x.y + h[2] * x.z)) + x.y * (h[3] * x.y + 2 * h[4] * x.z) + x.z * h[5] * x.z;
    return curved - 2 * dot(k, x) + c;
}

Quadratic plane_error(Vec3d a, Vec3d b, Vec3d c)
{
    const Vec3d across = cross(b - a, c - a);
    const double squared = dot(across, across);
    if (!(squared > 0))
        return {};
    // across is twice the area long, so its square times area^-0.75 is left.
    const double root = std::sqrt(std::sqrt(squared));
    const Vec3d n = across * (1 / (root * std::sqrt(root)));
    const Vec3d m = across;
    const double d = dot(m, a);
    return {{n.x * m.x, n.x * m.y, n.x * m.z, n.y * m.y, n.y * m.z, n.z * m.z}, n * d, dot(n, a) * d};
}

Quadratic line_error(Vec3d a, Vec3d b)
{
    // The squared area of the parallelogram that x spans with the edge: |a x b - x x (b - a)|².
    const Vec3d e = b - a;
    const Vec3d r = cross(a, b);
    const double squared = dot(e, e);
    return {{squared - e.x * e.x, -e.x * e.y, -e.x * e.z, squared - e.y * e.y, -e.y * e.z, squared - e.z * e.z},
            cross(e, r),
            dot(r, r)};
}

Placement place(const Quadratic& planes, const Quadratic* lines, Vec3d u, Vec3d v)
{
    const Vec3d middle = (u + v) * 0.5;
    const double squared_length = dot(u - v, u - v);
    Quadratic error = planes;
    if (lines != nullptr)  // the power brings both to meters to the power of 4.5
        error.add(*lines, 36 * line_weight * std::sqrt(std::sqrt(squared_length)));
    const double stiffness = error.trace();
    constexpr double none = std::numeric_limits<double>::infinity();
    if (!(stiffness > 0))
        return {middle, none};
    std::array<double, 6> h = error.h;
    const double pull = pull_share * stiffness;
    for (const std::size_t i : {0U, 3U, 5U})
        h[i] += pull;
    const Adjugate adjugate(h);
    const Vec3d point = adjugate.times(error.k + middle * pull) * (1 / adjugate.determinant);
    const Vec3d away = point - middle;
    if (!(dot(away, away) <= farthest_lengths * farthest_lengths * squared_length))
        return {middle, none};
    return {point, std::max(error(point), 0.0) + length_price * stiffness * squared_length};
}

namespace
{

/// A face may turn by up to 78°, and by less where it then looks against what was outside.
constexpr double least_cosine = 0.2;
/// A face's area may not be less than this share of its longest side squared, unless it is already.
constexpr double least_width = 1e-3;

double shape(Vec3d area_vector, Vec3d a, Vec3d b, Vec3d c)
{
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    return longest > 0 ? length(area_vector) / longest : 0;
}

/// Joins the halves of edges: sorted by the smaller vertex, then compared within its few.
std::vector<std::uint32_t> mates_of(const std::vector<std::uint32_t>& from, std::size_t vertices)
{
    const fresco::numerics::Buckets by_low(vertices,
                                           [&](const auto& add)
                                           {
                                               for (std::uint32_t h = 0; h < from.size(); ++h)
                                                   if ((h & 3U) != 3)
                                                       add(std::min(from[h], from[Piece::next(h)]), h);
                                           });
    std::vector<std::uint32_t> mates(from.size(), Piece::none);
    for (std::size_t v = 0; v < vertices; ++v)
        for (auto a = by_low[v].begin(); a != by_low[v].end(); ++a)
            for (auto b = a + 1; b != by_low[v].end() && mates[*a] == Piece::none; ++b)
                if (from[*a] == from[Piece::next(*b)] && from[Piece::next(*a)] == from[*b])
                {
                    mates[*a] = *b;
                    mates[*b] = *a;
                }
    return mates;
}

}  // namespace

Piece::Piece(std::vector<Vec3f> positions, std::vector<VertexLoad> loads, std::size_t frozen,
             const std::vector<fresco::Triangle>& faces)
    : positions_(std::move(positions)), loads_(std::move(loads)), frozen_(frozen), from_(4 * faces.size(), none),
      leaving_(positions_.size(), none), errors_(positions_.size()), versions_(positions_.size(), 0),
      marks_(positions_.size(), 0), faces_(faces.size())
{
    for (std::size_t f = 0; f < faces.size(); ++f)
        std::copy(faces[f].begin(), faces[f].end(), from_.begin() + static_cast<std::ptrdiff_t>(4 * f));
    mate_ = mates_of(from_, positions_.size());
    for (const Vec3f p : positions_)
        origin_ += fresco::vec_cast<double>(p) * (1.0 / static_cast<double>(positions_.size()));
    for (std::uint32_t h = 0; h < from_.size(); h += 4)
    {
        const Quadratic error = face_error(h);
        for (std::uint32_t k = h; k < h + 3; ++k)
        {
            errors_[from_[k]].add(error);
            if (leaving_[from_[k]] == none || mate_[k] == none)
                leaving_[from_[k]] = k;
        }
    }
}

Quadratic Piece::face_error(std::uint32_t h) const
{
    const std::uint32_t first = h & ~3U;
    return plane_error(relative(from_[first]), relative(from_[first + 1]), relative(from_[first + 2]));
}

std::uint32_t Piece::last_around(std::uint32_t v) const
{
    std::uint32_t last = none;
    around(v, [&](std::uint32_t h) { last = h; });
    return last;
}

void Piece::add_border(std::uint32_t v, std::uint32_t but, Quadratic& sum) const
{
    for (const std::uint32_t h : {leaving_[v], previous(last_around(v))})
        if (h != but)
            sum.add(line_error(relative(from(h)), relative(to(h))));
}

Placement Piece::placement(std::uint32_t h) const
{
    const std::uint32_t u = from(h);
    const std::uint32_t v = to(h);
    const std::uint32_t m = mate_[h];
    Quadratic star = errors_[u];
    star.add(errors_[v]);
    star.add(face_error(h), -1);
    if (m != none)
        star.add(face_error(m), -1);
    const bool u_border = border(u);
    const bool v_border = border(v);
    if (!u_border && !v_border)
        return place(star, nullptr, relative(u), relative(v));
    // The edge itself counts once where it is at the border.
    Quadratic line;
    if (u_border)
        add_border(u, none, line);
    if (v_border)
        add_border(v, m == none ? h : none, line);
    return place(star, &line, relative(u), relative(v));
}

bool Piece::allowed(std::uint32_t h, Vec3d point)
{
    return keeps_topology(h) && keeps_outside(h, point);
}

bool Piece::keeps_topology(std::uint32_t h)
{
    const std::uint32_t u = from(h);
    const std::uint32_t v = to(h);
    const std::uint32_t m = mate_[h];
    if (m != none && border(u) && border(v))
        return false;
    std::uint32_t allowed_common = 0;
    for (const std::uint32_t side : {h, m})
    {
        if (side == none)
            continue;
        ++allowed_common;
        const std::uint32_t after = mate_[next(side)];
        const std::uint32_t before = mate_[previous(side)];
        if (after == none && before == none)
            return false;  // an ear, or a face on its own, would go
        if (after != none && before != none && (after & ~3U) == (before & ~3U))
            return false;  // the third vertex would keep two faces, back to back
        if (after != none && before != none && mate_[previous(after)] == next(before))
            return false;  // the third vertex would keep two neighbors
    }
    // The link condition: no neighbors in common but the third vertices of the edge's faces.
    ++mark_;
    const auto neighbors = [&](std::uint32_t of, auto&& act)
    {
        around(of,
               [&](std::uint32_t leaving)
               {
                   act(to(leaving));
                   if (mate_[previous(leaving)] == none)
                       act(from(previous(leaving)));
               });
    };
    neighbors(u, [&](std::uint32_t w) { marks_[w] = mark_; });
    std::uint32_t common = 0;
    neighbors(v, [&](std::uint32_t w) { common += marks_[w] == mark_ ? 1 : 0; });
    return common == allowed_common;
}

bool Piece::keeps_outside(std::uint32_t h, Vec3d point) const
{
    const std::uint32_t u = from(h);
    const std::uint32_t v = to(h);
    const std::uint32_t removed[2] = {h & ~3U, mate_[h] == none ? none : mate_[h] & ~3U};
    const Vec3d outside = fresco::vec_cast<double>(loads_[u].normal) + fresco::vec_cast<double>(loads_[v].normal);
    bool good = true;
    const auto check = [&](std::uint32_t leaving)
    {
        if (!good || (leaving & ~3U) == removed[0] || (leaving & ~3U) == removed[1])
            return;
        const std::uint32_t b = to(leaving);
        const std::uint32_t c = from(previous(leaving));
        const Vec3d pa = relative(from(leaving));
        const Vec3d pb = relative(b);
        const Vec3d pc = relative(c);
        const Vec3d before = cross(pb - pa, pc - pa);
        const Vec3d after = cross(pb - point, pc - point);
        const double turn = dot(before, after);
        if (turn < least_cosine * std::sqrt(dot(before, before) * dot(after, after)))
            good = false;
        else if (const double now = shape(after, point, pb, pc); now < least_width && now < shape(before, pa, pb, pc))
            good = false;
        else
            for (const Vec3d away :
                 {outside, fresco::vec_cast<double>(loads_[b].normal), fresco::vec_cast<double>(loads_[c].normal)})
                if (dot(after, away) < 0 && dot(before, away) >= 0)
                    good = false;
    };
    around(u, check);
    around(v, check);
    return good;
}

void Piece::glue(std::uint32_t a, std::uint32_t b)
{
    if (a != none)
        mate_[a] = b;
    if (b != none)
        mate_[b] = a;
}

void Piece::turn_to_border(std::uint32_t v, std::uint32_t leaving)
{
    std::uint32_t h = leaving;
    while (mate_[h] != none)
    {
        h = next(mate_[h]);
        if (h == leaving)
            break;
    }
    leaving_[v] = h;
}

void Piece::collapse(std::uint32_t h, Vec3d point)
{
    const std::uint32_t u = from(h);
    const std::uint32_t v = to(h);
    const std::uint32_t sides[2] = {h, mate_[h]};

    // The sums of the neighbors lose the old faces …
    const auto each_face = [&](std::uint32_t of, bool also_shared, auto&& act)
    {
        around(of,
               [&](std::uint32_t leaving)
               {
                   const bool shared = (leaving & ~3U) == (h & ~3U) || (sides[1] != none && (leaving & ~3U) == (sides[1] & ~3U));
                   if (also_shared || !shared)
                       act(leaving);
               });
    };
    const auto leave = [&](std::uint32_t leaving)
    {
        const Quadratic error = face_error(leaving);
        for (const std::uint32_t corner : {next(leaving), previous(leaving)})
            if (from(corner) != u && from(corner) != v)
                errors_[from(corner)].add(error, -1);
    };
    each_face(u, true, leave);
    each_face(v, false, leave);

    std::uint32_t start = none;
    around(v, [&](std::uint32_t leaving) { from_[leaving] = u; });
    for (const std::uint32_t side : sides)
    {
        if (side == none)
            continue;
        const std::uint32_t after = mate_[next(side)];       // leaves the third vertex for h, or the kept one for the mate
        const std::uint32_t before = mate_[previous(side)];  // the other way round
        const std::uint32_t third = from(previous(side));
        glue(after, before);
        // In the face of h: next runs v → third, so its mate leaves the third vertex; the mate of previous leaves u. In the
        // mate's face u and v change places, and the same holds.
        turn_to_border(third, after != none ? after : next(before));
        if (start == none)
            start = before != none ? before : next(after);
        std::fill_n(from_.begin() + static_cast<std::ptrdiff_t>(side & ~3U), 3, none);
        --faces_;
    }
    turn_to_border(u, start);

    const float weight = loads_[u].area + loads_[v].area;
    const float share = weight > 0 ? loads_[v].area / weight : 0.5F;
    loads_[u].color = loads_[u].color * (1 - share) + loads_[v].color * share;
    loads_[u].area = weight;
    loads_[u].normal += loads_[v].normal;
    positions_[u] = fresco::vec_cast<float>(point + origin_);

    // … and gain the new ones.
    errors_[u] = {};
    ++versions_[u];
    around(u,
           [&](std::uint32_t leaving)
           {
               const Quadratic error = face_error(leaving);
               errors_[u].add(error);
               errors_[to(leaving)].add(error);
               errors_[from(previous(leaving))].add(error);
               ++versions_[to(leaving)];
               if (mate_[previous(leaving)] == none)
                   ++versions_[from(previous(leaving))];
           });
}

namespace
{
constexpr float no_offer = -1;
}

EdgeQueue::EdgeQueue(Piece& piece) : piece_(piece), offered_(piece.halves(), no_offer)
{
    later_.reserve(piece.halves() / 2);
    for (std::uint32_t h = 0; h < piece.halves(); ++h)
        if ((h & 3U) != 3 && (piece.mate(h) == Piece::none || h < piece.mate(h)) && free(h))
            offer(h);
}

void EdgeQueue::offer(std::uint32_t h)
{
    const auto cost = static_cast<float>(piece_.placement(h).cost);
    if (const std::uint32_t mate = piece_.mate(h); mate != Piece::none)
        offered_[mate] = no_offer;
    offered_[h] = no_offer;
    if (!std::isfinite(cost))
        return;
    offered_[h] = cost;
    const Entry entry{cost, h, version(h)};
    if (cost > most_)
    {
        later_.push_back(entry);
        return;
    }
    heap_.push_back(entry);
    std::push_heap(heap_.begin(), heap_.end(), after);
}

void EdgeQueue::admit(float most)
{
    most_ = most;
    const auto dear = std::partition(later_.begin(), later_.end(), [&](const Entry& entry) { return entry.cost > most; });
    for (auto entry = dear; entry != later_.end(); ++entry)
        if (offered_[entry->half] == entry->cost)
            heap_.push_back(*entry);
    later_.erase(dear, later_.end());
    std::make_heap(heap_.begin(), heap_.end(), after);
}

std::size_t EdgeQueue::run(float most, std::size_t faces)
{
    if (most > most_)
        admit(most);
    const std::size_t before = piece_.faces();
    while (!heap_.empty() && heap_.front().cost <= most && before - piece_.faces() < faces)
    {
        const Entry entry = heap_.front();
        std::pop_heap(heap_.begin(), heap_.end(), after);
        heap_.pop_back();
        // The edge may be gone, or have another entry.
        if (offered_[entry.half] != entry.cost || !piece_.alive(entry.half))
            continue;
        if (version(entry.half) != entry.version)
            offer(entry.half);
        else
            try_collapse(entry.half);
    }
    return before - piece_.faces();
}

void EdgeQueue::try_collapse(std::uint32_t h)
{
    offered_[h] = no_offer;
    const Placement placement = piece_.placement(h);
    if (!piece_.allowed(h, placement.point))
        return;
    const std::uint32_t kept = piece_.from(h);
    piece_.collapse(h, placement.point);
    piece_.around(kept,
                  [&](std::uint32_t leaving)
                  {
                      for (const std::uint32_t one : {leaving, Piece::next(leaving)})
                          if (free(one))
                              offer(one);
                      if (const std::uint32_t arriving = Piece::previous(leaving);
                          piece_.mate(arriving) == Piece::none && free(arriving))
                          offer(arriving);
                  });
}
