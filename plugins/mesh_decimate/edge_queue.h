#pragma once

#include "piece.h"

#include <cstddef>
#include <cstdint>
#include <vector>

/// Collapses edges of a piece, cheapest first, up to a price that rises from call to call. Edges whose two faces a collapse
/// changed are repriced at once; those that only touch the changed faces when their turn comes, as their prices mostly rise.
class EdgeQueue
{
  public:
    /// Prices every edge between free vertices. Keeps a reference to the piece.
    explicit EdgeQueue(Piece& piece);

    /// Removes up to `faces` faces (one more where the last collapse removes two) by collapses that cost at most `most`.
    /// Returns how many it removed.
    std::size_t run(float most, std::size_t faces);

    /// Calls visit(cost) for every edge that waits; for some more than once, at an earlier price.
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
    std::vector<Entry> later_;    ///< The dearer ones, in no order.
    std::vector<float> offered_;  ///< By half: the price of its valid entry; negative: none.
};
