#pragma once

#include "plugins/catalog.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file The reference documentation of stages and components, made of what their declarations say.

namespace fresco::host
{

/// Pages of Markdown by their files: TYPE.md, and README.md, the table of contents.
using ReferencePages = std::map<std::string, std::string>;

/// One page for each type that can be used, and the table of contents: types by kind, and which artifact who makes and takes.
/// The text depends only on the declarations, not on where libraries are. Throws Error if a declaration is malformed.
ReferencePages reference_pages(const Catalog& catalog);

/// Writes the pages into `folder`, which is made where it is missing, and removes pages that an earlier call wrote for types that
/// are gone; other files are left alone. Pages that are the same already are not touched. Returns the names of those that were
/// written or removed.
/// Throws Error naming the file that cannot be written.
std::vector<std::string> write_reference(const ReferencePages& pages, const std::filesystem::path& folder);

}  // namespace fresco::host
