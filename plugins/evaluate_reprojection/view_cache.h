#pragma once

#include "pair_figures.h"

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <utility>

/// Keeps the views used last, within a budget of memory: pairs share frames. Used by one thread.
class ViewCache
{
  public:
    using Loader = std::function<JudgedView(std::size_t)>;
    explicit ViewCache(Loader load) : load_(std::move(load)) {}

    std::shared_ptr<const JudgedView> get(std::size_t view)
    {
        for (auto entry = views_.begin(); entry != views_.end(); ++entry)
            if (entry->first == view)
            {
                views_.splice(views_.begin(), views_, entry);
                return views_.front().second;
            }
        views_.emplace_front(view, std::make_shared<const JudgedView>(load_(view)));
        const std::size_t bytes = views_.front().second->surface.depth.values.size() * bytes_per_pixel;
        while (views_.size() > 2 && views_.size() * bytes > budget_bytes)
            views_.pop_back();
        return views_.front().second;
    }

  private:
    static constexpr std::size_t bytes_per_pixel = 12;
    static constexpr std::size_t budget_bytes = std::size_t{256} << 20U;

    Loader load_;
    std::list<std::pair<std::size_t, std::shared_ptr<const JudgedView>>> views_;
};
