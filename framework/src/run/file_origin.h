#pragma once

#include "plugins/catalog.h"

#include <filesystem>
#include <iosfwd>
#include <string>

/// \file What `fresco describe` says of files. How a file was made is for a component of the kind `origin` to read, in a process
/// of its own; reports of runs are the host's.

namespace fresco::host
{

/// The type that reads how a file of this name was made; nullptr without one.
const TypeDescription* origin_reader(const Catalog& catalog, const std::string& file);

/// Prints that for a terminal of `width`. Throws Error naming the file, MissingInput where there is none.
void write_file_origin(const TypeDescription& reader, const std::filesystem::path& file, bool json, std::size_t width,
                       std::ostream& out);
/// The process that does it: sends {"origin": {…}} or {"error": text, "missing": bool}.
int internal_origin(const std::filesystem::path& library, const std::string& type, const std::filesystem::path& file);

/// Of a run.json or sweep.json: which run it reports. Throws Error where it is another file.
void write_run_origin(const std::filesystem::path& file, bool json, std::ostream& out);

}  // namespace fresco::host
