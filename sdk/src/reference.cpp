#include "reference.h"

#include <fresco/artifact.h>
#include <fresco/error.h>
#include <fresco/input_roots.h>

#include <algorithm>

namespace fresco
{
namespace
{
namespace fs = std::filesystem;

constexpr std::string_view own_prefix = "own:";
constexpr std::string_view store_prefix = "store:";
constexpr std::string_view file_prefix = "file:";

/// `place`: of the file, below the store's root.
void note_result(const fs::path& place, const ArtifactFolder& folder)
{
    auto part = place.begin();
    if (*part == "tmp" || *part == "checkpoints")
        throw Error((folder.store / place).string() +
                    ": will be gone when the stage is done; refer only to files in the artifact's own folder or in an input's");
    if (folder.references != nullptr && *part == "objects" && ++part != place.end())
        folder.references->insert(part->string());
}

/// A file that a reference names below a folder.
fs::path named_below(const fs::path& folder, std::string_view prefix, const std::string& reference)
{
    const fs::path name = reference.substr(prefix.size());
    if (name.empty() || name.is_absolute() || std::ranges::find(name, fs::path("..")) != name.end())
        throw Error("reference \"" + reference + "\" leads out of its folder: use \"file:\" and an absolute path");
    return folder / name;
}

}  // namespace

std::optional<std::string> detail::below(const fs::path& path, const fs::path& base)
{
    if (base.empty())
        return std::nullopt;
    const fs::path relative = path.lexically_relative(base);
    if (relative.empty() || *relative.begin() == ".." || relative == ".")
        return std::nullopt;
    return relative.generic_string();
}

std::string reference_to(const fs::path& file, const ArtifactFolder& folder)
{
    if (const auto name = detail::below(file, folder.path))
        return std::string(own_prefix) + *name;
    if (const auto place = detail::below(file, folder.store))
    {
        note_result(*place, folder);
        return std::string(store_prefix) + *place;
    }
    // A folder without a store is for a program of the user's, which knows only paths.
    if (std::string name = input_name(fs::absolute(file).lexically_normal()); !folder.store.empty() && is_input_name(name))
        return name;
    return std::string(file_prefix) + fs::absolute(file).string();
}

fs::path referred_file(const std::string& reference, const ArtifactFolder& folder)
{
    if (reference.starts_with(own_prefix))
        return named_below(folder.path, own_prefix, reference);
    if (reference.starts_with(store_prefix))
        return named_below(folder.store, store_prefix, reference);
    if (reference.starts_with(file_prefix))
        return reference.substr(file_prefix.size());
    if (!is_input_name(reference))
        throw Error("reference \"" + reference + "\" does not begin with own:, store:, input: or file:");
    fs::path file = input_path(reference);
    if (file == reference)
        throw Error("reference \"" + reference + "\" is below a folder that the pipeline does not name under 'inputs'");
    return file;
}

}  // namespace fresco
