#include <fresco/geometry/disk.h>

#include <fresco/numerics/disjoint_sets.h>

#include <algorithm>
#include <deque>

namespace fresco::geometry
{
namespace
{

/// One chart's edges, by place in its list of faces: edge k of face i is half 3 i + k.
class Cutter
{
  public:
    Cutter(const Surface& surface, const std::vector<std::uint32_t>& faces)
        : surface_(surface), faces_(faces), mate_(3 * faces.size(), none), joined_(3 * faces.size(), false)
    {
        for (std::uint32_t i = 0; i < faces.size(); ++i)
            for (std::uint32_t k = 0; k < 3; ++k)
            {
                vertices_.push_back(surface.mesh.triangles[faces[i]][k]);
                const auto at = std::lower_bound(faces.begin(), faces.end(), surface.neighbors[faces[i]][k]);
                if (at == faces.end() || *at != surface.neighbors[faces[i]][k])
                    continue;
                const auto j = static_cast<std::uint32_t>(at - faces.begin());
                for (std::uint32_t m = 0; m < 3; ++m)
                    if (corner(3 * j + m) == end(3 * i + k) && end(3 * j + m) == corner(3 * i + k))
                        mate_[3 * i + k] = 3 * j + m;
            }
        std::sort(vertices_.begin(), vertices_.end());
        vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    }

    void join_all()
    {
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            joined_[h] = mate_[h] != none;
    }

    /// By Euler's number: 2 - 2 x handles - closed border lines.
    bool is_disk_with_holes()
    {
        numerics::DisjointSets corners(mate_.size());
        std::size_t inner = 0;
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (mate_[h] != none)
            {
                corners.join(h, next(mate_[h]));
                ++inner;
            }
        numerics::DisjointSets lines(mate_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (mate_[h] == none)
                lines.join(corners.find(h), corners.find(next(h)));
        std::ptrdiff_t vertices = 0;
        std::ptrdiff_t borders = 0;
        std::vector<bool> counted(mate_.size(), false);
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
        {
            vertices += corners.find(h) == h ? 1 : 0;
            if (mate_[h] != none)
                continue;
            const auto line = lines.find(corners.find(h));
            borders += counted[line] ? 0 : 1;
            counted[line] = true;
        }
        const auto edges = static_cast<std::ptrdiff_t>(mate_.size() - inner / 2);
        const auto euler = vertices - edges + static_cast<std::ptrdiff_t>(faces_.size());
        return borders > 0 && euler == 2 - borders;
    }

    void join_tree()
    {
        std::vector<bool> reached(faces_.size(), false);
        std::deque<std::uint32_t> front{0};
        reached[0] = true;
        while (!front.empty())
        {
            const auto i = front.front();
            front.pop_front();
            for (auto h = 3 * i; h < 3 * i + 3; ++h)
                if (mate_[h] != none && !reached[mate_[h] / 3])
                {
                    reached[mate_[h] / 3] = true;
                    join(h);
                    front.push_back(mate_[h] / 3);
                }
        }
    }

    /// A cut that ends in a vertex with no other open edge separates nothing. Of a closed surface two edges stay open.
    void close_free_cuts()
    {
        std::vector<std::vector<std::uint32_t>> open(vertices_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (!joined_[h] && (mate_[h] == none || h < mate_[h]))
                for (const auto v : {place(corner(h)), place(end(h))})
                    open[v].push_back(h);
        const bool closed = std::find(mate_.begin(), mate_.end(), none) == mate_.end();
        auto cuts = std::count(joined_.begin(), joined_.end(), false) / 2;
        std::deque<std::size_t> ends;
        for (std::size_t v = 0; v < open.size(); ++v)
            ends.push_back(v);
        while (!ends.empty())
        {
            const auto v = ends.front();
            ends.pop_front();
            if (open[v].size() != 1 || mate_[open[v].front()] == none || (closed && cuts == 2))
                continue;
            const auto h = open[v].front();
            join(h);
            --cuts;
            for (const auto w : {place(corner(h)), place(end(h))})
            {
                std::erase(open[w], h);
                ends.push_back(w);
            }
        }
    }

    Disk take() const
    {
        Disk disk;
        numerics::DisjointSets corners(mate_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
        {
            if (joined_[h])
                corners.join(h, next(mate_[h]));
            else if (mate_[h] != none && h < mate_[h])
                ++disk.cut_edges;
        }
        std::vector<std::uint32_t> index(mate_.size(), none);
        disk.triangles.resize(faces_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
        {
            auto& v = index[corners.find(h)];
            if (v == none)
            {
                v = static_cast<std::uint32_t>(disk.points.size());
                disk.points.push_back(vec_cast<double>(surface_.mesh.positions[corner(h)]));
            }
            disk.triangles[h / 3][h % 3] = v;
        }
        return disk;
    }

  private:
    static std::uint32_t next(std::uint32_t half) { return half / 3 * 3 + (half % 3 + 1) % 3; }
    std::uint32_t corner(std::uint32_t half) const { return surface_.mesh.triangles[faces_[half / 3]][half % 3]; }
    std::uint32_t end(std::uint32_t half) const { return corner(next(half)); }
    std::size_t place(std::uint32_t vertex) const
    {
        return static_cast<std::size_t>(std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
    }
    void join(std::uint32_t half) { joined_[half] = joined_[mate_[half]] = true; }

    const Surface& surface_;
    const std::vector<std::uint32_t>& faces_;
    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> mate_;
    std::vector<bool> joined_;
};

}  // namespace

Disk cut_to_disk(const Surface& surface, const std::vector<std::uint32_t>& faces)
{
    Cutter cutter(surface, faces);
    if (cutter.is_disk_with_holes())
        cutter.join_all();
    else
    {
        cutter.join_tree();
        cutter.close_free_cuts();
    }
    return cutter.take();
}

}  // namespace fresco::geometry
