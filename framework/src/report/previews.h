#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include "report/page.h"
#include "store/store.h"
#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file Pictures of artifacts for the page of a run.

namespace fresco::host
{

/// A stage whose artifacts a page may show.
struct ShownStage
{
    const PipelineStage* stage = nullptr;
    std::string object;              ///< Its result; empty: none.
    std::vector<std::string> names;  ///< Of its exported files, those to show, and nothing else; empty: all that it has.
};

/// The page that artifacts are shown on.
struct ShowingPage
{
    std::filesystem::path out;     ///< Where the run exports to.
    std::filesystem::path folder;  ///< Where the page lies.
    int longest_px = 720;          ///< Of its pictures.
};

/// Requests for make_previews: the artifacts of the stages, and those read from users' files, that a viewer shows. The stages are
/// in a topological order.
Value preview_requests(const std::vector<ShownStage>& stages, const Catalog& catalog, const Store& store,
                       const ShowingPage& page);

/// In a process of its own: opens plugins, loads the artifacts and lets their viewers show them. What cannot be shown has a note.
PageMedia make_previews(const Value& requests, const Store& store);

}  // namespace fresco::host
