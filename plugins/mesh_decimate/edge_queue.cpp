#include "edge_queue.h"

#include <algorithm>
#include <cmath>

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
