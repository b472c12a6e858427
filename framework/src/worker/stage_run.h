#pragma once

#include "store/store.h"
#include "worker/worker.h"
#include "worker/worker_channel.h"

#include <string>

namespace fresco::host
{

/// An input that the store no longer has as it was: its maker must run again.
struct DamagedInput
{
    Damage damage;
};

/// The stage of one request, from the lock to the published result, told to the channel. `temporary`: how the names of its
/// temporary folders begin, by which the host finds what a killed worker left. Once in a process: a plugin may leave anything
/// behind. Throws DamagedInput, PluginFailure, MissingInput, Canceled, Error, and whatever the stage throws.
void run_stage(WorkerRequest request, std::string temporary, WorkerChannel& channel);

}  // namespace fresco::host
