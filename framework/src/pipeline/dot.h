#pragma once

#include "pipeline/pipeline.h"

#include <iosfwd>
#include <string>
#include <string_view>

namespace fresco::host
{

/// The pipeline as a graph for Graphviz: stages with their types, files that are read, ports and artifacts on the edges.
void write_dot(const Pipeline& pipeline, std::ostream& out);

/// A quoted identifier of the DOT language.
std::string dot_quoted(std::string_view text);

}  // namespace fresco::host
