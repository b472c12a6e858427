#pragma once

#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include <fresco/value.h>

#include <map>
#include <string>

/// \file Names a result by all that decides it. Whatever can change a result must be in here, and nothing else.

namespace fresco::host
{

/// Everything that determines a stage's result and is known before it runs, as a map: format, type, options (those in the key,
/// input files by contents), inputs (per port the result it comes from, or the file's contents and its reader) and libraries (of
/// the stage and its components: contents and versions). `objects` maps an upstream stage to its result. Throws MissingInput if
/// an input file is gone.
Value key_document(const PipelineStage& stage, const std::map<std::string, std::string>& objects, FileHashes& hashes);

std::string key_of(const Value& key_document);

/// Changes from one key document to another, for a person: "max_faces was 500000, is 300000". Empty without changes.
std::string explain_difference(const Value& before, const Value& now, const PipelineStage& stage);

}  // namespace fresco::host
