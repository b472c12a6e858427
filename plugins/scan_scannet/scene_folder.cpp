#include "scene_folder.h"

#include <fresco/error.h>

#include <algorithm>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace scannet
{

namespace
{

constexpr std::string_view full_mesh = "_vh_clean.ply";
constexpr std::string_view reduced_mesh = "_vh_clean_2.ply";

std::vector<fs::path> files_ending(const fs::path& folder, std::string_view ending, fresco::RunContext& run)
{
    run.reads_folder(folder, "*" + std::string(ending));
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string().ends_with(ending))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

fs::path find_mesh(const fs::path& path, std::string_view kind, fresco::RunContext& run)
{
    auto files = kind == "reduced" ? std::vector<fs::path>{} : files_ending(path, full_mesh, run);
    if (files.empty() && kind != "full")
        files = files_ending(path, reduced_mesh, run);
    if (files.empty() && kind == "auto")
        return {};
    if (files.empty())
        throw fresco::MissingInput(path.string() + ": no mesh " + (kind == "full" ? "*_vh_clean.ply" : "*_vh_clean_2.ply") +
                                   "; put it there or set option \"mesh\"");
    if (files.size() > 1)
        throw fresco::Error(path.string() + ": several meshes, " + files[0].filename().string() + " and " +
                            files[1].filename().string() + "; choose one with option \"mesh\"");
    return files[0];
}

fs::path find_properties(const fs::path& path, fresco::RunContext& run)
{
    const auto named = path / (fs::weakly_canonical(path).filename().string() + ".txt");
    if (fs::exists(named))
        return named;
    const auto files = files_ending(path, ".txt", run);
    return files.size() == 1 ? files[0] : fs::path{};
}

}  // namespace scannet
