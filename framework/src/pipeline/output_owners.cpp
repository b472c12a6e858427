#include "pipeline/output_owners.h"

namespace fresco::host
{
namespace fs = std::filesystem;

std::optional<std::string> OutputOwners::claim(const fs::path& path, const std::string& stage, const std::string& option)
{
    const auto owner = owners_.emplace(path.lexically_normal(), stage).first;
    if (owner->second == stage)
        return std::nullopt;
    return "the stages " + owner->second + " and " + stage + " would both write " + owner->first.generic_string() +
           " below --out: give one of them another " + option;
}

}  // namespace fresco::host
