#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"

#include <iosfwd>
#include <string>
#include <vector>

/// \file What `check`, `stages`, `describe`, `graph` and `schema` print. An int is the exit code. Tables fit a terminal of
/// `width`; the caller folds the rest.

namespace fresco::host
{

/// A line per problem; of many that are alike the first few, and how many more there are.
void write_problems(const std::vector<Problem>& problems, std::ostream& out);
/// The same as a list of maps: file, line, column, kind (invalid, missing_input, plugin), text.
Value problems_as_value(const std::vector<Problem>& problems);

/// The problems, or one line that there are none; as JSON {file, ok, stages, problems}.
int write_check(const PipelineResult& result, bool json, std::ostream& out);

/// Stages and components with their kind; with `all` also their libraries, the types that several libraries have, and what cannot
/// be loaded and why.
int write_stages(const Catalog& catalog, bool all, bool json, std::size_t width, std::ostream& out);

/// Ports, options, defaults, ranges and help of one type; as JSON its declaration. A type that cannot be used is said in
/// `errors`.
int write_description(const Catalog& catalog, const std::string& type, bool json, std::size_t width, std::ostream& out,
                      std::ostream& errors);

/// The pipeline in the DOT language; its problems, if it has any, go to `errors`.
int write_graph(const PipelineResult& result, std::ostream& out, std::ostream& errors);

/// The JSON Schema of pipeline files.
int write_schema(const Catalog& catalog, std::ostream& out);

}  // namespace fresco::host
