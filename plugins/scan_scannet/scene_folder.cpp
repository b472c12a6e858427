#include "scene_folder.h"

#include <fresco/error.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

namespace fs = std::filesystem;

namespace scannet
{

namespace
{

constexpr std::string_view full_mesh = "_vh_clean.ply";
constexpr std::string_view reduced_mesh = "_vh_clean_2.ply";

fs::path named_properties(const fs::path& path)
{
    return path / (fs::weakly_canonical(path).filename().string() + ".txt");
}

std::optional<long> number_of(const std::string& stem)
{
    long number = 0;
    const auto [end, code] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (stem.empty() || stem.front() == '-' || code != std::errc{} || end != stem.data() + stem.size())
        return std::nullopt;
    return number;
}

std::map<long, fs::path> numbered_files(const fs::path& folder, const std::vector<std::string>& extensions)
{
    if (!fs::is_directory(folder))
        throw fresco::MissingInput(folder.string() +
                                   ": no such folder; expected an exported scene with color/N.jpg, depth/N.png, pose/N.txt");
    std::map<long, fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
    {
        const auto& file = entry.path();
        const auto number = number_of(file.stem().string());
        if (!number || std::find(extensions.begin(), extensions.end(), file.extension().string()) == extensions.end())
            continue;
        if (!files.emplace(*number, file).second)
            throw fresco::Error(file.string() + ": there is another file of this number, " + files[*number].filename().string() +
                                "; remove one");
    }
    return files;
}

fs::path file_of(const std::map<long, fs::path>& files, long number, const fs::path& expected, std::vector<std::string>& missing)
{
    const auto found = files.find(number);
    if (found != files.end())
        return found->second;
    missing.push_back(expected.string());
    return {};
}

std::vector<fs::path> files_ending(const fs::path& folder, std::string_view ending)
{
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string().ends_with(ending))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

std::vector<fresco::ViewFiles> list_views(const fs::path& path, int every)
{
    const auto color = numbered_files(path / "color", {".jpg", ".png"});
    const auto depth = numbered_files(path / "depth", {".png"});
    const auto pose = numbered_files(path / "pose", {".txt"});
    std::map<long, int> numbers;
    for (const auto* files : {&color, &depth, &pose})
        for (const auto& [number, file] : *files)
            numbers[number] = 0;
    if (numbers.empty())
        throw fresco::MissingInput(path.string() + ": the scene has no views; expected color/0.jpg, depth/0.png, pose/0.txt, …");

    std::vector<fresco::ViewFiles> views;
    std::vector<std::string> missing;
    int index = 0;
    for (const auto& [number, unused] : numbers)
    {
        if (index++ % every != 0)
            continue;
        const std::string name = std::to_string(number);
        views.push_back({"scene", name, number, file_of(color, number, path / "color" / (name + ".jpg"), missing),
                         file_of(depth, number, path / "depth" / (name + ".png"), missing),
                         file_of(pose, number, path / "pose" / (name + ".txt"), missing)});
    }
    fresco::refuse_missing(missing, "each view needs color, depth and pose");
    return views;
}

fs::path find_mesh(const fs::path& path, std::string_view kind)
{
    auto files = kind == "reduced" ? std::vector<fs::path>{} : files_ending(path, full_mesh);
    if (files.empty() && kind != "full")
        files = files_ending(path, reduced_mesh);
    if (files.empty())
        throw fresco::MissingInput(path.string() + ": no mesh " +
                                   (kind == "full"      ? "*_vh_clean.ply"
                                    : kind == "reduced" ? "*_vh_clean_2.ply"
                                                        : "*_vh_clean.ply or *_vh_clean_2.ply") +
                                   "; put it there or give the option mesh");
    if (files.size() > 1)
        throw fresco::Error(path.string() + ": several meshes, " + files[0].filename().string() + " and " +
                            files[1].filename().string() + "; name one with the option mesh");
    return files[0];
}

std::vector<std::string> mesh_names(const fs::path& mesh, std::string_view kind)
{
    std::vector<std::string> names;
    if (kind != "reduced")
        names.push_back("*" + std::string(full_mesh));
    if (mesh.filename().string().ends_with(reduced_mesh))
        names.push_back("*" + std::string(reduced_mesh));
    return names;
}

fs::path find_properties(const fs::path& path)
{
    const auto named = named_properties(path);
    if (fs::exists(named))
        return named;
    const auto files = files_ending(path, ".txt");
    return files.size() == 1 ? files[0] : fs::path{};
}

std::string properties_names(const fs::path& path, const fs::path& properties)
{
    const auto named = named_properties(path);
    return properties == named ? named.filename().string() : "*.txt";
}

}  // namespace scannet
