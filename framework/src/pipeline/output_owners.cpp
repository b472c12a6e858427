#include "pipeline/output_owners.h"

#include <algorithm>

namespace fresco::host
{
namespace fs = std::filesystem;

std::string OutputOwners::blocked(const Owners::value_type& file, const Owners::value_type& below, const std::string& option)
{
    return "the stage " + file.second.stage + " would write the file " + file.first.generic_string() +
           " below --out, and the stage " + below.second.stage + " would write " + below.first.generic_string() +
           ": give one of them another " + option;
}

std::optional<std::string> OutputOwners::claim(const fs::path& path, const std::string& stage, bool is_file,
                                               const std::string& option)
{
    const auto own = owners_.emplace(path.lexically_normal(), Owner{stage, is_file}).first;
    const fs::path& name = own->first;
    if (own->second.stage != stage)
        return "the stages " + own->second.stage + " and " + stage + " would both write " + name.generic_string() +
               " below --out: give one of them another " + option;
    // What is below a path comes after it.
    if (const auto next = std::next(own);
        is_file && next != owners_.end() && std::ranges::mismatch(name, next->first).in1 == name.end())
        return blocked(*own, *next, option);
    for (fs::path above = name.parent_path(); !above.empty(); above = above.parent_path())
        if (const auto file = owners_.find(above); file != owners_.end() && file->second.is_file)
            return blocked(*file, *own, option);
    return std::nullopt;
}

}  // namespace fresco::host
