#include "piece.h"

#include <algorithm>
#include <cmath>

using fresco::Vec3d;
using fresco::Vec3f;

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
    std::vector<std::uint32_t> begin(vertices + 1, 0);
    const auto each = [&](auto&& act)
    {
        for (std::uint32_t h = 0; h < from.size(); ++h)
            if ((h & 3U) != 3)
                act(std::min(from[h], from[Piece::next(h)]), h);
    };
    each([&](std::uint32_t low, std::uint32_t) { ++begin[low + 1]; });
    for (std::size_t v = 0; v < vertices; ++v)
        begin[v + 1] += begin[v];
    std::vector<std::uint32_t> sorted(begin.back());
    auto next = begin;
    each([&](std::uint32_t low, std::uint32_t h) { sorted[next[low]++] = h; });
    std::vector<std::uint32_t> mates(from.size(), Piece::none);
    for (std::size_t v = 0; v < vertices; ++v)
        for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i)
            for (std::uint32_t j = i + 1; j < begin[v + 1] && mates[sorted[i]] == Piece::none; ++j)
                if (from[sorted[i]] == from[Piece::next(sorted[j])] && from[Piece::next(sorted[i])] == from[sorted[j]])
                {
                    mates[sorted[i]] = sorted[j];
                    mates[sorted[j]] = sorted[i];
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
