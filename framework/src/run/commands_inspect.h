#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

/// \file What `check`, `stages`, `describe` and `schema` print. An int is the exit code. Tables fit a terminal of
/// `width`; the caller folds the rest. How a file was made is for a component of the kind `origin` to read, in a process of
/// its own; reports of runs are the host's.

namespace fresco::host
{

/// The type that reads how a file of this name was made; nullptr without one.
const TypeDescription* origin_reader(const Catalog& catalog, const std::string& file);

/// Prints how the file was made, for a terminal of `width` columns. Throws Error naming the file, MissingInput if it does not
/// exist.
void write_file_origin(const TypeDescription& reader, const std::filesystem::path& file, bool json, std::size_t width,
                       std::ostream& out);
/// The process that does it: sends {"origin": {…}} or {"error": text, "missing": bool}.
int internal_origin(const std::filesystem::path& library, const std::string& type, const std::filesystem::path& file);

/// As a list of maps: file, line, column, kind (invalid, missing_input, plugin, warning), text.
Value problems_as_value(const std::vector<Problem>& problems);

/// The problems, or one line that there are none; as JSON {file, ok, stages, problems, warnings}.
int write_check(const PipelineResult& result, bool json, std::ostream& out);

/// Stages and components with their kind; with `all` also their libraries, the types that several libraries have, and what cannot
/// be loaded and why.
int write_stages(const Catalog& catalog, bool all, bool json, std::size_t width, std::ostream& out);

/// Ports, options, defaults, ranges and help of one type; as JSON its declaration. A type that cannot be used is said in
/// `errors`.
int write_description(const Catalog& catalog, const std::string& type, bool json, std::size_t width, std::ostream& out,
                      std::ostream& errors);

/// Unusable types with the reason, a line for each.
std::vector<std::string> unusable_lines(const Catalog& catalog);
/// As lists of maps: ambiguous, shadowed, `refused_name`, unbuilt.
Value::Map unusable_types(const Catalog& catalog, const char* refused_name);

}  // namespace fresco::host
