#pragma once

#include <filesystem>
#include <string>

namespace fresco::host
{

/// "1:02:03", "2:03", "41 s".
std::string duration_text(double seconds);
/// "12.3 s", "350 MB": for tables.
std::string size_text(double megabytes);
/// Relative to the working directory where it is below that.
std::string path_text(const std::filesystem::path& path);
/// As a shell reads it back.
std::string shell_word(const std::string& text);
/// Why a text cannot stand in a script: with control characters a line could end in it, and a command begin. Empty: it can.
/// `name` is the option that it comes from.
std::string script_problem(const std::string& name, const std::string& text);

}  // namespace fresco::host
