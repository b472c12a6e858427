#pragma once

#include "plugins/catalog.h"
#include "store/store.h"
#include <fresco/value.h>
#include <fresco/viewer.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file Pages of results: data for other programs, and one HTML file that draws them and fetches nothing.

namespace fresco::host
{

struct Page
{
    std::filesystem::path json;
    std::filesystem::path html;
    Value data;             ///< Of `json`; the page draws the same.
    Value previews;         ///< What there is to look at: see preview_requests.
    std::string signature;  ///< Of the results that the page shows.
    std::string hurry;      ///< Why no pictures are made; empty: they are.
};

/// Throws Error where one of the two files is there and fresco did not write it.
void check_replaceable(const Page& page);

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

/// Of the program and of all that its pages are made of.
std::string page_version();

/// What the previews came to.
struct PageMedia
{
    Value::List entries;                      ///< {stage, port, artifact, pictures, notes, …}: pipelines/results.md.
    std::vector<const PageScripts*> scripts;  ///< What draws them.
};

std::string page_html(const Value& data, const PageMedia& media, const std::string& signature);

}  // namespace fresco::host
