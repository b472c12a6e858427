#include "worker/scratch_folder.h"

#include <cstdlib>
#include <system_error>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr const char* name_begins = "fresco-";

/// Empty where it is not set.
fs::path temporary_folder()
{
    const char* folder = std::getenv("TMPDIR");
    return folder == nullptr ? fs::path() : fs::path(folder);
}

}  // namespace

fs::path make_scratch_folder(const Store& store, const std::string& prefix)
{
    if (const fs::path folder = temporary_folder(); folder.is_absolute())
    {
        std::string name = (folder / (name_begins + prefix + ".XXXXXX")).string();
        if (::mkdtemp(name.data()) != nullptr)
            return name;
    }
    return store.make_temporary(prefix);
}

std::string temporary_folder_in(const std::string& text)
{
    const fs::path folder = temporary_folder();
    return folder.is_absolute() && text.find((folder / name_begins).string()) != std::string::npos ? folder.string() : "";
}

void remove_scratch_folders(const std::string& prefix)
{
    std::error_code error;
    const fs::path folder = temporary_folder();
    if (!folder.is_absolute())
        return;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
        if (entry.path().filename().string().starts_with(name_begins + prefix + "."))
            remove_quietly(entry.path());
}

}  // namespace fresco::host
