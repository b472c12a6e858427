#include "reference.h"

#include <fresco/artifact.h>
#include <fresco/error.h>

namespace fresco
{
namespace
{
namespace fs = std::filesystem;

constexpr std::string_view own = "own:";
constexpr std::string_view stored = "store:";
constexpr std::string_view outside = "file:";

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
        return std::string(own) + *name;
    if (const auto place = detail::below(file, folder.store))
    {
        note_result(*place, folder);
        return std::string(stored) + *place;
    }
    return std::string(outside) + fs::absolute(file).string();
}

fs::path referred_file(const std::string& reference, const ArtifactFolder& folder)
{
    if (reference.starts_with(own))
        return folder.path / reference.substr(own.size());
    if (reference.starts_with(stored))
        return folder.store / reference.substr(stored.size());
    if (reference.starts_with(outside))
        return reference.substr(outside.size());
    throw Error("reference \"" + reference + "\" does not begin with own:, store: or file:");
}

}  // namespace fresco
