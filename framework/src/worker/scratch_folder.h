#pragma once

#include "store/store.h"

#include <filesystem>
#include <string>

namespace fresco::host
{

/// A new empty folder for what a stage needs while it runs: below $TMPDIR where that is set, as clusters do for the node's own
/// disk; else, or where that cannot be written, in the store. `prefix`, which is unique, is a part of its name.
std::filesystem::path make_scratch_folder(const Store& store, const std::string& prefix);
/// $TMPDIR, if the text names a file of a scratch folder there; else empty.
std::string temporary_folder_in(const std::string& text);
/// Removes those of this prefix below $TMPDIR, which a process left that could not.
void remove_scratch_folders(const std::string& prefix);

}  // namespace fresco::host
