#include "view_feed.h"

#include <c10/core/DeviceGuard.h>
#include <c10/core/StreamGuard.h>
#include <c10/core/impl/VirtualGuardImpl.h>

#include <exception>
#include <utility>

namespace fresco::optimize
{
namespace
{

/// Views in memory in addition to the current one: one waits while the next is made.
constexpr std::size_t views_ahead = 2;

std::optional<c10::Stream> side_stream(const torch::Device& device)
{
    if (device.is_cpu())
        return std::nullopt;
    return c10::impl::VirtualGuardImpl(device.type()).getStreamFromGlobalPool(device, false);
}

}  // namespace

ViewFeed::ViewFeed(const torch::Device& device, std::size_t first, std::size_t last, const Make& make)
    : device_(device), stream_(side_stream(device)),
      loader_(first, last, views_ahead, [this, make](std::size_t index) { return load(index, make); })
{
}

ViewFeed::~ViewFeed()
{
    try
    {
        let_go();
    }
    catch (const std::exception&)
    {
        // The device has failed, and what it said first is on its way up.
        return;
    }
}

ViewFeed::Loaded ViewFeed::load(std::size_t index, const Make& make) const
{
    if (!stream_)
        return {make(index), std::nullopt};
    const c10::DeviceGuard on_device(device_);
    const c10::StreamGuard on_stream(*stream_);
    Loaded loaded{make(index), c10::Event(device_.type())};
    loaded.sent->record(*stream_);
    return loaded;
}

void ViewFeed::let_go()
{
    if (present_.data && stream_)
    {
        // The view's memory belongs to the side stream, which may use it again at once, but work on it may not have ended.
        c10::Event done(device_.type());
        done.record(c10::impl::VirtualGuardImpl(device_.type()).getStream(device_));
        done.block(*stream_);
    }
    present_ = {};
}

ViewData& ViewFeed::next()
{
    auto loaded = loader_.next();
    let_go();
    present_ = std::move(loaded);
    if (present_.sent)
        present_.sent->block(c10::impl::VirtualGuardImpl(device_.type()).getStream(device_));
    return *present_.data;
}

}  // namespace fresco::optimize
