#include <fresco/geometry/flatten.h>
#include <fresco/numerics/disjoint_sets.h>

#include <queue>
#include <tuple>
#include <unordered_map>

namespace fresco::geometry
{

namespace
{

/// Position of a face in the chart's ascending list, or `none`.
std::uint32_t place_of(const std::vector<std::uint32_t>& faces, std::uint32_t face)
{
    const auto at = std::lower_bound(faces.begin(), faces.end(), face);
    return at != faces.end() && *at == face ? static_cast<std::uint32_t>(at - faces.begin()) : none;
}

/// The place where the largest connected part without conflicts begins; if every face has conflicts, the largest face.
std::uint32_t best_seed(const Surface& surface, const std::vector<std::uint32_t>& faces,
                        const std::vector<std::array<std::uint32_t, 3>>& around, const std::vector<bool>& clean)
{
    numerics::DisjointSets parts(faces.size());
    for (std::uint32_t i = 0; i < faces.size(); ++i)
        for (const auto j : around[i])
            if (j != none && clean[i] && clean[j])
                parts.join(i, j);
    std::vector<double> area(faces.size(), 0.0);
    bool any_clean = false;
    for (std::uint32_t i = 0; i < faces.size(); ++i)
        any_clean = any_clean || clean[i];
    for (std::uint32_t i = 0; i < faces.size(); ++i)
        if (clean[i] || !any_clean)
            area[parts.find(i)] += surface.areas[faces[i]];
        else
            area[i] = -1;
    return static_cast<std::uint32_t>(std::max_element(area.begin(), area.end()) - area.begin());
}

}  // namespace

std::vector<std::uint32_t> injective_part(const Surface& surface, const Corners& corners, const std::vector<std::uint32_t>& faces,
                                          Vec3d axis, double tolerance)
{
    std::vector<std::array<std::uint32_t, 3>> around(faces.size(), {none, none, none});
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto g = surface.neighbors[faces[i]][k]; g != none)
                around[i][k] = place_of(faces, g);

    const auto overlaps = find_overlaps(corners, faces, tolerance);
    std::vector<bool> clean(faces.size(), true);
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> conflicts;
    for (const auto& [a, b] : overlaps)
    {
        const auto i = place_of(faces, a);
        const auto j = place_of(faces, b);
        conflicts[i].push_back(j);
        conflicts[j].push_back(i);
        clean[i] = clean[j] = false;
    }

    struct Candidate
    {
        bool conflicted;
        double turn;
        std::uint32_t place;
        bool operator<(const Candidate& other) const
        {
            return std::tie(other.conflicted, other.turn, other.place) < std::tie(conflicted, turn, place);
        }
    };
    enum class State : std::uint8_t
    {
        open,
        kept,
        blocked
    };
    std::vector<State> state(faces.size(), State::open);
    std::priority_queue<Candidate> queue;
    queue.push({false, 0, best_seed(surface, faces, around, clean)});
    while (!queue.empty())
    {
        const auto i = queue.top().place;
        queue.pop();
        if (state[i] != State::open)
            continue;
        state[i] = State::kept;
        if (!clean[i])
            for (const auto j : conflicts[i])
                state[j] = State::blocked;
        for (const auto j : around[i])
            if (j != none && state[j] == State::open)
                queue.push({!clean[j], -dot(surface.normals[faces[j]], axis), j});
    }
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < faces.size(); ++i)
        if (state[i] == State::kept)
            kept.push_back(faces[i]);
    return kept;
}

}  // namespace fresco::geometry
