#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>

namespace fresco::host
{

/// Identifies a process, also among those of other machines that use the same disk.
struct ProcessIdentity
{
    /// The boot of a machine and its space of process numbers: `pid` means something only to processes with the same.
    std::string machine;
    pid_t pid = 0;
    std::uint64_t start = 0;  ///< Clock ticks since the boot.

    /// "0123456789ab-4711-123456", for names of files.
    std::string text() const;
    bool is_on_this_machine() const;
    /// Whether it still runs. Only of a process on this machine.
    bool is_running() const;
};

ProcessIdentity this_process();
/// The one whose text the name of a file begins with; nothing if it begins otherwise.
std::optional<ProcessIdentity> process_named_by(std::string_view name);

/// "process 4711 on kitchen, since 2026-11-23 13:05:10", for people: this process and now.
std::string holder_text();

}  // namespace fresco::host
