#include <fresco/geometry/flatten.h>

#include <map>
#include <optional>
#include <set>

namespace fresco::geometry
{

namespace
{

/// Charts of at most this many faces are tried.
constexpr std::size_t crumb_faces = 32;
/// … and of at most this many texels: what is larger is no noise and stays undistorted.
constexpr double crumb_texels = 256;
constexpr int largest_patch_rings = 3;
constexpr int relaxation_sweeps = 60;
/// A relaxed face keeps at least this share of its area, or too few texels are left for it.
constexpr double smallest_area_share = 0.05;

class Unfolder
{
  public:
    Unfolder(const Surface& surface, FlatCharts& flat, double texel_m)
        : surface_(surface), flat_(flat), tolerance_(1e-3 * texel_m), largest_area_(crumb_texels * texel_m * texel_m),
          lists_(Partition{flat.chart_of_face, flat.axes}.faces()), changed_(lists_.size(), false),
          begin_(surface.mesh.positions.size() + 1, 0)
    {
        for (const auto& t : surface.mesh.triangles)
            for (const auto v : t)
                ++begin_[v + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        around_.resize(begin_.back());
        auto next = begin_;
        for (std::uint32_t f = 0; f < surface.mesh.triangles.size(); ++f)
            for (const auto v : surface.mesh.triangles[f])
                around_[next[v]++] = f;
    }

    /// Lays the crumb, if need be with the crumbs around it, into its chart with the longest common border. Returns that chart,
    /// or `none` if it does not fit there.
    std::uint32_t unfold(std::uint32_t crumb)
    {
        const auto chart = longest_neighbour(lists_[crumb]);
        if (chart == none)
            return none;
        for (const bool with_crumbs : {false, true})
        {
            std::set<std::uint32_t> patch(lists_[crumb].begin(), lists_[crumb].end());
            for (int rings = 1; rings <= largest_patch_rings; ++rings)
            {
                add_ring(patch, chart, with_crumbs);
                for (const bool unrolled : {false, true})
                {
                    const auto layout = relaxed(patch, chart, unrolled);
                    if (layout && is_injective(patch, *layout))
                    {
                        take(patch, chart, *layout);
                        return chart;
                    }
                }
            }
        }
        return none;
    }

    /// A chart of few faces and texels that has kept its own.
    bool is_crumb(std::uint32_t chart) const
    {
        const auto& faces = lists_[chart];
        if (faces.empty() || faces.size() > crumb_faces || changed_[chart] || flat_.chart_of_face[faces.front()] != chart)
            return false;
        double area = 0;
        for (const auto f : faces)
            area += surface_.areas[f];
        return area <= largest_area_;
    }

    std::vector<bool> changed() const { return changed_; }

  private:
    using Layout = std::map<std::uint32_t, Vec2d>;

    std::span<const std::uint32_t> faces_around(std::uint32_t vertex) const
    {
        return std::span(around_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
    }

    std::uint32_t longest_neighbour(const std::vector<std::uint32_t>& crumb) const
    {
        std::map<std::uint32_t, double> lengths;
        const auto own = flat_.chart_of_face[crumb.front()];
        for (const auto f : crumb)
            for (std::size_t k = 0; k < 3; ++k)
                if (const auto g = surface_.neighbours[f][k]; g != none && flat_.chart_of_face[g] != own)
                {
                    const auto& t = surface_.mesh.triangles[f];
                    const auto edge = surface_.mesh.positions[t[(k + 1) % 3]] - surface_.mesh.positions[t[k]];
                    lengths[flat_.chart_of_face[g]] += static_cast<double>(length(edge));
                }
        // A large chart goes before any crumb: two halves of one fold belong into what is around both.
        const auto longest =
            std::max_element(lengths.begin(), lengths.end(),
                             [&](const auto& a, const auto& b)
                             { return std::pair(!is_crumb(a.first), a.second) < std::pair(!is_crumb(b.first), b.second); });
        return longest == lengths.end() ? none : longest->first;
    }

    void add_ring(std::set<std::uint32_t>& patch, std::uint32_t chart, bool with_crumbs) const
    {
        const std::vector<std::uint32_t> inner(patch.begin(), patch.end());
        for (const auto f : inner)
            for (const auto v : surface_.mesh.triangles[f])
                for (const auto g : faces_around(v))
                {
                    const auto other = flat_.chart_of_face[g];
                    if (other == chart)
                        patch.insert(g);
                    else if (with_crumbs && is_crumb(other))
                        patch.insert(lists_[other].begin(), lists_[other].end());
                }
    }

    /// All faces around are in the patch and close up.
    bool is_free(std::uint32_t vertex, const std::set<std::uint32_t>& patch) const
    {
        for (const auto f : faces_around(vertex))
        {
            if (!patch.contains(f))
                return false;
            for (std::size_t k = 0; k < 3; ++k)
                if (surface_.mesh.triangles[f][k] == vertex &&
                    (surface_.neighbours[f][k] == none || surface_.neighbours[f][(k + 2) % 3] == none))
                    return false;
        }
        return true;
    }

    /// Places vertices that one edge with placed ends connects, as if the face were turned about that edge into the plane.
    void unroll(const std::set<std::uint32_t>& patch, Layout& layout) const
    {
        for (bool placed = true; placed;)
        {
            placed = false;
            for (const auto f : patch)
                for (std::size_t k = 0; k < 3; ++k)
                {
                    const auto& t = surface_.mesh.triangles[f];
                    const auto a = layout.find(t[k]);
                    const auto b = layout.find(t[(k + 1) % 3]);
                    const auto apex = t[(k + 2) % 3];
                    if (a == layout.end() || b == layout.end() || layout.contains(apex))
                        continue;
                    const auto base = vec_cast<double>(surface_.mesh.positions[t[k]]);
                    const auto edge = vec_cast<double>(surface_.mesh.positions[t[(k + 1) % 3]]) - base;
                    const auto side = vec_cast<double>(surface_.mesh.positions[apex]) - base;
                    const auto flat_edge = b->second - a->second;
                    if (!(dot(edge, edge) > 0) || !(dot(flat_edge, flat_edge) > 0))
                        continue;
                    const double along = dot(side, edge) / dot(edge, edge);
                    const double height = length(cross(edge, side)) / length(edge);
                    const Vec2d left = normalized(Vec2d{-flat_edge.y, flat_edge.x});
                    layout[apex] = a->second + flat_edge * along + left * height;
                    placed = true;
                }
        }
    }

    /// The patch with its border where it was and every inner vertex in the middle of its neighbours (Tutte 1963); nothing if a
    /// face is folded or squeezed.
    std::optional<Layout> relaxed(const std::set<std::uint32_t>& patch, std::uint32_t chart, bool unrolled) const
    {
        const PlaneFrame frame(flat_.axes[chart]);
        Layout layout;
        for (const auto f : patch)
            for (std::size_t k = 0; k < 3; ++k)
                if (flat_.chart_of_face[f] == chart)
                    layout[surface_.mesh.triangles[f][k]] = flat_.corners[3 * std::size_t{f} + k];
        if (unrolled)
            unroll(patch, layout);
        for (const auto f : patch)
            for (const auto v : surface_.mesh.triangles[f])
                layout.try_emplace(v, frame.project(vec_cast<double>(surface_.mesh.positions[v])));
        std::vector<std::pair<std::uint32_t, std::set<std::uint32_t>>> free;
        for (const auto& [v, place] : layout)
            if (is_free(v, patch))
            {
                free.emplace_back(v, std::set<std::uint32_t>{});
                for (const auto f : faces_around(v))
                    for (const auto w : surface_.mesh.triangles[f])
                        if (w != v)
                            free.back().second.insert(w);
            }
        for (int sweep = 0; sweep < relaxation_sweeps && !free.empty(); ++sweep)
            for (const auto& [v, ring] : free)
            {
                Vec2d sum{};
                for (const auto w : ring)
                    sum = sum + layout.at(w);
                layout.at(v) = sum * (1.0 / static_cast<double>(ring.size()));
            }
        for (const auto f : patch)
        {
            const auto& t = surface_.mesh.triangles[f];
            const auto a = layout.at(t[0]);
            if (0.5 * cross(layout.at(t[1]) - a, layout.at(t[2]) - a) < smallest_area_share * surface_.areas[f])
                return std::nullopt;
        }
        return layout;
    }

    void take(const std::set<std::uint32_t>& patch, std::uint32_t chart, const Layout& layout)
    {
        for (const auto f : patch)
        {
            flat_.unfolded_faces += flat_.chart_of_face[f] != chart ? 1 : 0;
            flat_.chart_of_face[f] = chart;
            flat_.projected[f] = 0;
            for (std::size_t k = 0; k < 3; ++k)
                flat_.corners[3 * std::size_t{f} + k] = layout.at(surface_.mesh.triangles[f][k]);
        }
        changed_[chart] = true;
    }

    bool is_injective(const std::set<std::uint32_t>& patch, const Layout& layout) const
    {
        Corners corners;
        for (const auto f : patch)
            for (const auto v : surface_.mesh.triangles[f])
                corners.push_back(layout.at(v));
        std::vector<std::uint32_t> all(patch.size());
        std::iota(all.begin(), all.end(), 0u);
        return find_overlaps(corners, all, tolerance_).empty();
    }

    const Surface& surface_;
    FlatCharts& flat_;
    double tolerance_;
    double largest_area_;
    std::vector<std::vector<std::uint32_t>> lists_;  ///< The charts' faces before any crumb moved.
    std::vector<bool> changed_;
    std::vector<std::size_t> begin_;
    std::vector<std::uint32_t> around_;
};

}  // namespace

std::vector<bool> unfold_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress)
{
    Unfolder unfolder(surface, flat, texel_m);
    std::size_t tried = 0;
    for (std::uint32_t c = 0; c < flat.axes.size(); ++c)
    {
        if (!unfolder.is_crumb(c))
            continue;
        if (++tried % 64 == 0)
            progress.check_cancelled();
        unfolder.unfold(c);
    }
    return unfolder.changed();
}

}  // namespace fresco::geometry
