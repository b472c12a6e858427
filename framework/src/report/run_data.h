#pragma once

#include "report/report.h"
#include "store/store.h"
#include <fresco/value.h>

/// \file What run.json and sweep.json say in the same way (pipelines/results.md).

namespace fresco::host
{

/// Format, versions, time, command and pipeline; `format` is "fresco-run" or "fresco-sweep".
Value::Map origin_data(const ReportRequest& request, const char* format);

/// A stage's entry of "stages": what it came to, and how it was made. A manifest that cannot be read leaves its figures empty.
Value stage_data(const PipelineStage& stage, const StageOutcome* outcome, const Store& store);

}  // namespace fresco::host
