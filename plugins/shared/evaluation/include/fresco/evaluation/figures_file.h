#pragma once

#include <fresco/artifact.h>
#include <fresco/files.h>
#include <fresco/value.h>

#include <string>

namespace fresco::evaluation
{

/// Writes figures as JSON to `path` below the folder of an output, and returns the output's value.
Files write_figures(const ArtifactFolder& folder, const std::string& path, const Value& figures);

}  // namespace fresco::evaluation
