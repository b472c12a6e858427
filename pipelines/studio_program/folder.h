#pragma once

#include <fresco/value.h>
#include <room_file.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file What a folder has to paint, and the only way from a name in a request to a file.

namespace fresco::studio
{

/// The file or folder `name` below `base`, a canonical path, if it exists and no step, link or "..", leads out of it. Names with
/// a hidden step are refused, too.
std::optional<std::filesystem::path> below(const std::filesystem::path& base, std::string_view name);

/// How a layout of recordings knows its folders, as `fresco describe --json` tells.
struct Layout
{
    std::string type{};
    std::vector<std::string> contains{};    ///< Marks::contains of the SDK.
    std::vector<std::string> extensions{};  ///< Extensions of recordings that are one file.
};

struct Scan
{
    std::string name;  ///< Relative to the folder; ".": the folder itself.
    paint::ScanKind kind = paint::ScanKind::recording;
    std::string layout;     ///< Type of a recording's layout.
    std::string thumbnail;  ///< A picture of it, relative to the folder; empty: none.
};

struct Contents
{
    std::vector<Scan> scans;
    std::vector<std::string> pictures;  ///< Relative to the folder.
    std::vector<std::string> weights;   ///< Files that may hold a network's weights, by their names.
    std::vector<std::string> runs;      ///< Output folders with a progress.jsonl.
    bool is_cut = false;                ///< There was more than this program looks at.
};

/// Looks at most three folders deep and at 20 000 entries; hidden ones are passed over, and what is inside of a recording is its
/// own.
Contents contents_of(const std::filesystem::path& folder, const std::vector<Layout>& layouts);

bool is_picture(const std::filesystem::path& file);
/// A model or splats in one file that the page may offer.
bool is_model(const std::filesystem::path& file);

/// Moves an uploaded file into the folder under a name like `wanted`, never over another file; gives the name. Throws Error for
/// a name that is neither a picture's nor a model's, and for contents that do not begin as such files do.
std::string take_in(const std::filesystem::path& upload, const std::filesystem::path& folder, const std::string& wanted);

/// This is what the page gets: {scans: [{name, kind, layout, thumbnail}], pictures, runs, is_cut}
Value as_value(const Contents& contents);

}  // namespace fresco::studio
