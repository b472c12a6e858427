#pragma once

#include "base/process.h"
#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include "run/exports.h"
#include "run/scheduler.h"
#include "store/store.h"
#include <fresco/value.h>
#include <fresco/viewer.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file Pages of results: data for other programs, and one HTML file that draws them, with pictures of artifacts, and fetches
/// nothing.

namespace fresco::host
{

struct Page
{
    std::filesystem::path json;
    std::filesystem::path html;  ///< In the same folder.
    OutputOwner owner;
    bool replace = false;     ///< --replace: overwrite the two files, whoever wrote them.
    Value data{};             ///< Contents of `json`, which the page draws.
    Value previews{};         ///< Requests for previews: see preview_requests.
    std::string signature{};  ///< Signature of the results that the page shows.
    std::string hurry{};      ///< Why no pictures are made; empty: they are.
};

/// The summary page of a matrix: sweep.json and sweep.html.
Page sweep_page(const RunRequest& run);

/// Knows which files no page may replace. Made once for the pages of a run.
struct PageGuard
{
    explicit PageGuard(const RunRequest& run);

    KnownFiles inputs;
    FileHashes hashes;
};

/// Why the two files may not be written: the user's own are in the way.
std::vector<std::string> page_obstacles(const Page& page, PageGuard& guard);
/// Throws Error where there are obstacles, or one of the two files is among those that stages exported.
void check_replaceable(const Page& page, PageGuard& guard, const std::vector<Exporter::File>& exported);

/// Whether both files are there, and of results with this signature.
bool is_current(const Page& page);

/// Writes the data, whole or not at all. Throws Error if that fails.
void write_data(const Page& page);

/// Writes the HTML, whole or not at all. Pictures are made in a process of its own, as what opens one may crash and the host
/// opens no plugin; where that fails the page has none and says so, and is not taken for current. What went wrong; empty:
/// nothing. Throws Error if the file cannot be written. The host must be single-threaded.
std::string write_html(const Page& page, const Catalog& catalog, const Store& store);

/// The components that show artifacts, as {type: {library, hash}}; another of these makes another page.
Value viewers_of(const Catalog& catalog);

/// Version of the program and of all parts of its pages.
std::string page_version();

// Files of framework/report/, built in by CMake.
extern const std::string_view report_css;
extern const std::string_view report_js;

/// Results of the previews.
struct PageMedia
{
    Value::List entries;                      ///< {stage, port, artifact, pictures, notes, …}: pipelines/results.md.
    std::vector<const PageScripts*> scripts;  ///< Scripts that draw them.
};

/// Waits for the end of a process that makes a page. It says what it shows next over the channel, and is killed, with all that it
/// started, where that takes longer than `limit`. What went wrong, with what was being shown; empty: nothing.
std::string wait_for_page(const Child& child, std::chrono::milliseconds limit);

std::string page_html(const Value& data, const PageMedia& media, const std::string& signature);

/// A stage whose artifacts a page may show.
struct ShownStage
{
    const PipelineStage* stage = nullptr;
    std::string object;              ///< Its result; empty: none.
    std::vector<std::string> names;  ///< Exported files to show, and nothing else; empty: all that it has.
};

/// The page that artifacts are shown on.
struct ShowingPage
{
    std::filesystem::path out;     ///< Folder of the run's exports.
    std::filesystem::path folder;  ///< Folder of the page.
    int longest_px = 720;          ///< Longer side of its pictures.
};

/// Request for internal_page: the artifacts of the stages, and those read from users' files, that have a viewer. The
/// stages are in a topological order.
Value preview_requests(const std::vector<ShownStage>& stages, const Catalog& catalog, const Store& store,
                       const ShowingPage& page);

}  // namespace fresco::host
