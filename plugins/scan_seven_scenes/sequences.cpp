#include "sequences.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <string>

namespace seven_scenes
{

namespace fs = std::filesystem;

std::vector<fs::path> list_sequences(const fs::path& path, const std::vector<int>& wanted, fresco::RunContext& run)
{
    run.reads_folder(path, "seq-*");
    std::map<long, fs::path> found;
    for (const auto& entry : fs::directory_iterator(path))
        if (const auto number = fresco::recordings::number_after(entry.path().filename().string(), "seq-");
            number && entry.is_directory() && !found.emplace(*number, entry.path()).second)
            throw fresco::Error(fmt::format("{}: two folders for sequence {}; remove one", path.string(), *number));
    if (found.empty())
        throw fresco::MissingInput(path.string() +
                                   ": no sequences; expected folders seq-01, seq-02, … with frame-000000.color.png (or .jpg), "
                                   "frame-000000.depth.png and frame-000000.pose.txt");
    std::string numbers;
    for (const auto& [number, folder] : found)
        numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
    for (const int number : wanted)
        if (!found.contains(number))
            throw fresco::MissingInput(fmt::format("{}: no sequence {}; found {}", path.string(), number, numbers));
    std::vector<fs::path> folders;
    for (const auto& [number, folder] : found)
        if (wanted.empty() || std::ranges::find(wanted, number) != wanted.end())
            folders.push_back(folder);
    return folders;
}

}  // namespace seven_scenes
