#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file Asks plugins that were never seen what they hold, in processes of their own: a bad one takes nothing along. The
/// search for plugins uses it.

namespace fresco::host
{

/// What opening a plugin in a child process brought.
struct Probe
{
    std::filesystem::path library;
    /// Map: types (list of type, kind, help, declaration), versions, own_libraries. Null if it is refused.
    Value description;
    std::string refusal;
    /// The refusal lies in the file itself (and not, say, in a library that is not installed): it may be remembered.
    bool lasting = false;
};

/// Opens each library in a child process, `parallel` at a time. One that hangs is ended after 5 s, one that crashes harms nobody.
std::vector<Probe> probe_plugins(const std::vector<std::filesystem::path>& libraries, int parallel);

/// The child: `fresco internal-probe FILE`. Opens the library, makes one object of each type and writes what it declares to the
/// channel. Returns the exit code.
int internal_probe(const std::filesystem::path& library);

}  // namespace fresco::host
