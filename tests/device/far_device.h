#pragma once

#include <torch/types.h>

#include <cstdint>
#include <map>
#include <string>

/// \file For tests: a device whose memory the processor cannot read, as with CUDA, on a machine that has none. Every operator of
/// libtorch runs there by its CPU kernel; any other access to a tensor's memory ends the process. An operator that is given
/// tensors of both sides throws. What would make the processor wait for a real device is counted.

namespace fresco::testing
{

/// The device. A program that calls this has it from its start on: libtorch asks which devices there are only once.
torch::Device far_device();

/// Since the last call of forget_far_traffic(). On any thread.
struct FarTraffic
{
    std::int64_t to_device = 0;        ///< Copies from the processor's memory for which it would wait …
    std::int64_t to_device_later = 0;  ///< … and for which it would not.
    std::map<std::string, std::int64_t>
        waits;  ///< By operator: copies to the processor, and results whose size depends on values.
    std::map<std::string, std::int64_t> launches;  ///< By operator, copies among them; views and new tensors need none.
    std::int64_t events_recorded = 0;
    std::int64_t events_awaited = 0;
    std::int64_t wait_count() const;
};
FarTraffic far_traffic();
void forget_far_traffic();

}  // namespace fresco::testing
