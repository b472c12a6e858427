#pragma once

#include <fresco/option_declaration.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file Finds, before anything runs, a file that cannot be what a pipeline names it for. The check of options and of files
/// on ports uses it, with the formats that plugins declare.

namespace fresco::host
{

/// Why nothing can be seen at a path, by errno: "the path is too long", "cannot be reached: Permission denied". Empty: nothing is
/// there.
std::string unreachable_text(int error);

/// The name of the format without extensions that a file is in: such formats are refused by what they are. Empty: none.
std::string known_kind(const std::filesystem::path& file, const std::vector<FileFormat>& formats);

/// Why a file cannot be what an option or reader wants that takes files with these extensions (".png") and in these formats:
/// "'a.ply' is empty", "'a.ply' is not a PLY mesh". Empty where nothing speaks against it, for an extension without a format, and
/// for a file that cannot be read. Reads a few kilobytes of a file that is fine.
std::string file_problem(const std::filesystem::path& file, const std::vector<std::string>& extensions,
                         const std::vector<FileFormat>& formats);

}  // namespace fresco::host
