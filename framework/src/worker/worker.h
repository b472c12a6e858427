#pragma once

#include "base/file_stamp.h"
#include "base/process.h"
#include "store/store.h"
#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file The process that runs one stage: what it is asked by the host, what it answers, and its way in. The host writes the
/// request; nothing else passes between them but files of the store.

namespace fresco::host
{

/// A new empty folder for what a stage needs while it runs: below $TMPDIR where that is set, as clusters do for the node's own
/// disk; else, or where that cannot be written, in the store. `prefix`, which is unique, is a part of its name.
std::filesystem::path make_scratch_folder(const Store& store, const std::string& prefix);
/// $TMPDIR, if the text names a file of a scratch folder there; else empty.
std::string temporary_folder_in(const std::string& text);
/// Removes those of this prefix below $TMPDIR, which a process left that could not.
void remove_scratch_folders(const std::string& prefix);

/// One input of a stage as the worker gets it: a stored output, or a user's file and its reader.
struct WorkerInput
{
    std::string port;
    std::string from;    ///< STAGE.OUTPUT, for error texts.
    std::string object;  ///< Empty for a file.
    std::string output;
    std::vector<std::string> references;  ///< Objects that `object` refers to.
    std::filesystem::path file;
    Value reader;
};

/// Ends errors about paths below --out. Never advise removal: the path may be a link to an input.
inline constexpr const char* another_out = "choose another folder with --out";

/// In a folder of pictures of a running stage: fresco made it, and may replace what is in it.
inline constexpr const char* progress_mark = ".fresco-progress";

/// All that a process of its own needs to run one stage. The host writes it as JSON.
struct WorkerRequest
{
    std::filesystem::path store;
    std::filesystem::path out;  ///< Output folder of the run. Links below it are not followed.
    std::filesystem::path preview_folder;
    std::string stage;
    std::string type;
    Value options;
    std::string key;
    Value key_document;
    std::vector<WorkerInput> inputs;
    std::map<std::string, std::filesystem::path> libraries;  ///< Type -> plugin, for the stage and its components.
    std::vector<Dependency> files;                           ///< Input files as they were when the key was made.
    int threads = 1;
    bool on_gpu = false;
};

/// The child: `fresco internal-run REQUEST.json`. Takes the key's lock, looks whether the result is there by now, checks the
/// inputs against their hashes, runs the stage and publishes its result. Speaks JSON lines to the channel:
///   {"event": "waiting", holder}, {"event": "running"}, {"event": "progress", done, total, unit, metrics},
///   {"event": "message" | "warning", text}, {"event": "damaged", object, text}, {"event": "failed", text},
///   {"event": "canceled"}, {"event": "done", object, references, stored, seconds, memory_mb, disk_mb}
/// Does not return.
[[noreturn]] void internal_run(const std::filesystem::path& request_file);

}  // namespace fresco::host
