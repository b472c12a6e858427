#pragma once

#include "plugins/catalog.h"

#include <filesystem>
#include <string>
#include <vector>

/// \file The reference documentation of stages and components, made of what their declarations say.

namespace fresco::host
{

/// A page of Markdown.
struct ReferencePage
{
    std::string file;  ///< TYPE.md, or README.md: the table of contents.
    std::string text;
};

/// One page for each type that can be used, and the table of contents: types by kind, and which artifact who makes and takes.
/// The text depends only on the declarations, not on where libraries are. Throws Error if a declaration is malformed.
std::vector<ReferencePage> reference_pages(const Catalog& catalog);

/// Writes the pages into `folder`, which is made where it is missing, and removes pages that an earlier call wrote for types that
/// are gone; other files are left alone. Pages that are the same already are not touched. Returns the names of those that were
/// written or removed.
/// Throws Error naming the file that cannot be written.
std::vector<std::string> write_reference(const std::vector<ReferencePage>& pages, const std::filesystem::path& folder);

/// One line for each page in `folder` that is missing, is not as write_reference would write it, or is of no type.
std::vector<std::string> reference_differences(const std::vector<ReferencePage>& pages, const std::filesystem::path& folder);

}  // namespace fresco::host
