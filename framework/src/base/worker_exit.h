#pragma once

namespace fresco::host
{

/// Exit codes of a worker that did not finish its stage; 0 means that it did.
enum WorkerExit
{
    worker_failed = 1,
    worker_missing_input = 3,
    worker_plugin = 4,
    worker_damaged_input = 10,  ///< The event "damaged" names the object.
    worker_lost_channel = 11,   ///< Something in the process closed the channel.
    worker_canceled = 75
};

}  // namespace fresco::host
