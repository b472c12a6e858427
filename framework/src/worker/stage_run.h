#pragma once

#include "store/store.h"
#include "worker/worker.h"
#include "worker/worker_context.h"
#include <fresco/value.h>

#include <string>
#include <string_view>

/// \file Runs one stage in the worker, from the lock of its key to the published result, and tells how the result came about.
/// Each manifest keeps all of that: those of earlier results may be gone, or in another store.

namespace fresco::host
{

/// Adds the figures of the last entry, from a stage's report: numbers, texts, and short lists and maps of them. Times are left
/// out, which differ from run to run: names that end in `_s` or contain `seconds`.
Value with_figures(Value origin, const Value& report);

/// The text with the folders of an absolute path dropped: "--in=/home/ann/scan" becomes "--in=scan".
std::string without_folders(std::string_view text);

/// The stage of one request, from the lock to the published result, told to the channel. `temporary`: how the names of its
/// temporary folders begin, by which the host finds what a killed worker left. Once in a process: a plugin may leave anything
/// behind. Throws Damage, PluginFailure, MissingInput, Canceled, Error, and whatever the stage throws.
void run_stage(WorkerRequest request, std::string temporary, WorkerChannel& channel);

}  // namespace fresco::host
