#pragma once

#include "prefetch.h"
#include "view_data.h"

#include <c10/core/Event.h>
#include <c10/core/Stream.h>
#include <torch/types.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

namespace fresco::optimize
{

/// The views of a run, one after the other: a thread makes the next ones ready while the present one is worked on. For another
/// device than the CPU it also sends them there, on a stream of its own, so that neither the thread nor the device waits for the
/// other. Memory: the present view and those ahead. Used by one thread.
class ViewFeed
{
  public:
    using Make = std::function<std::unique_ptr<ViewData>(std::size_t)>;

    /// make(first), make(first + 1), … make(last - 1), on another thread.
    ViewFeed(const torch::Device& device, std::size_t first, std::size_t last, const Make& make);
    ~ViewFeed();
    ViewFeed(const ViewFeed&) = delete;
    ViewFeed& operator=(const ViewFeed&) = delete;

    /// Lets go of the present view and goes on to the next. Rethrows what make threw.
    ViewData& next();

  private:
    struct Loaded
    {
        std::unique_ptr<ViewData> data;
        std::optional<c10::Event> sent;
    };
    Loaded load(std::size_t index, const Make& make) const;
    void let_go();

    torch::Device device_;
    std::optional<c10::Stream> stream_;  ///< None on the CPU.
    Loaded present_;
    Prefetch<Loaded> loader_;
};

}  // namespace fresco::optimize
