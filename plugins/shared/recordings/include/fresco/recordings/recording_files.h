#pragma once

#include <fresco/option.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Finding the files of a recording. What the result depends on is said to the run.
namespace fresco::recordings
{

/// Files of one kind: `folder`/`prefix`, digits and one of `endings`, such as color/000012.jpg.
struct NumberedFiles
{
    std::filesystem::path folder;
    std::string prefix;
    std::vector<std::string> endings;
};

/// The views whose color, depth and, where `pose` has endings, pose files have the same number, by number. Their name is the
/// color file's prefix and digits. A partner that is missing has the path where it is expected; a folder that is missing holds
/// nothing. Throws Error for two files of one kind and number, and for two spellings of a number by files of one folder and
/// prefix.
std::vector<RecordedView> numbered_views(const NumberedFiles& color, const NumberedFiles& depth, const NumberedFiles& pose,
                                         RunContext& run);

/// Says that the result depends on which names match `pattern`, a path whose last part may have '*' and '?'. Its folder need not
/// be there.
void looks_for(const std::filesystem::path& pattern, RunContext& run);

/// The file that an option gives, else the first of `candidates` that is there; else none.
std::optional<std::filesystem::path> find_file(const InputFile& given, const std::vector<std::filesystem::path>& candidates,
                                               RunContext& run);
/// FILE or FILE, or set option "OPTION".
std::string expected_files(const std::vector<std::filesystem::path>& candidates, std::string_view option);

/// As find_file. Throws MissingInput that names the candidates and the option, and says that `what` is missing.
std::filesystem::path first_file(const InputFile& given, const std::vector<std::filesystem::path>& candidates,
                                 std::string_view what, std::string_view option, RunContext& run);

/// The text of a file, which the result then depends on. Throws as read_text_file does.
std::string recorded_text(const std::filesystem::path& file, RunContext& run);

}  // namespace fresco::recordings
