#include "scan_folder.h"

#include <fresco/error.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <string_view>

namespace fs = std::filesystem;

namespace
{

/// The number of "seq-01" or "frame-000008", or nothing if `text` is not the prefix and digits.
std::optional<long> number_after(std::string_view text, std::string_view prefix)
{
    if (!text.starts_with(prefix) || text.size() == prefix.size())
        return std::nullopt;
    const auto digits = text.substr(prefix.size());
    long number = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (code != std::errc{} || end != digits.data() + digits.size() || digits.front() == '-')
        return std::nullopt;
    return number;
}

std::map<long, fs::path> list_sequences(const fs::path& path)
{
    std::map<long, fs::path> found;
    for (const auto& entry : fs::directory_iterator(path))
        if (const auto number = number_after(entry.path().filename().string(), "seq-"); number && entry.is_directory())
            if (!found.emplace(*number, entry.path()).second)
                throw fresco::Error(path.string() + ": two folders of sequence " + std::to_string(*number));
    if (found.empty())
        throw fresco::MissingInput(path.string() +
                                   ": no sequences; expected folders seq-01, seq-02, … with frame-000000.color.png (or .jpg), "
                                   "frame-000000.depth.png and frame-000000.pose.txt");
    return found;
}

std::map<long, fs::path> chosen_sequences(const fs::path& path, const std::vector<int>& wanted)
{
    const auto found = list_sequences(path);
    if (wanted.empty())
        return found;
    std::map<long, fs::path> chosen;
    for (const int number : wanted)
    {
        const auto sequence = found.find(number);
        if (sequence == found.end())
        {
            std::string names;
            for (const auto& [other, folder] : found)
                names += (names.empty() ? "" : ", ") + std::to_string(other);
            throw fresco::MissingInput(path.string() + ": there is no sequence " + std::to_string(number) + "; there are " +
                                       names);
        }
        chosen.insert(*sequence);
    }
    return chosen;
}

/// Files that exist of one frame; sorts them into their places by what follows the first dot.
void take_file(fresco::ViewFiles& frame, const fs::path& file, std::string_view ending)
{
    if (ending == "depth.png")
        frame.depth = file;
    else if (ending == "pose.txt")
        frame.pose = file;
    else if (ending == "color.png" || ending == "color.jpg" || ending == "color.jpeg")
    {
        if (!frame.color.empty())
            throw fresco::Error(file.string() + ": the frame has another color picture, " + frame.color.filename().string() +
                                "; remove one");
        frame.color = file;
    }
}

std::map<long, fresco::ViewFiles> list_frames(const fs::path& folder)
{
    std::map<long, fresco::ViewFiles> frames;
    for (const auto& entry : fs::directory_iterator(folder))
    {
        const std::string file_name = entry.path().filename().string();
        const auto dot = file_name.find('.');
        if (dot == std::string::npos || !entry.is_regular_file())
            continue;
        const std::string name = file_name.substr(0, dot);
        const auto number = number_after(name, "frame-");
        if (!number)
            continue;
        auto& frame = frames[*number];
        if (!frame.name.empty() && frame.name != name)
            throw fresco::Error(entry.path().string() + ": two names for frame " + std::to_string(*number) + ", the other is " +
                                frame.name);
        frame.sequence = folder.filename().string();
        frame.name = name;
        frame.number = *number;
        take_file(frame, entry.path(), std::string_view(file_name).substr(dot + 1));
    }
    return frames;
}

void note_missing(const fresco::ViewFiles& frame, const fs::path& folder, std::vector<std::string>& missing)
{
    if (frame.color.empty())
        missing.push_back((folder / (frame.name + ".color.png")).string() + " (or .color.jpg)");
    if (frame.depth.empty())
        missing.push_back((folder / (frame.name + ".depth.png")).string());
    if (frame.pose.empty())
        missing.push_back((folder / (frame.name + ".pose.txt")).string());
}

}  // namespace

ScanFolder list_scan(const fs::path& path, const std::vector<int>& sequences, int every)
{
    ScanFolder scan;
    std::vector<std::string> missing;
    for (const auto& [number, folder] : chosen_sequences(path, sequences))
    {
        scan.sequences.push_back(folder);
        int index = 0;
        for (auto& [frame_number, frame] : list_frames(folder))
        {
            if (index++ % every != 0)
                continue;
            note_missing(frame, folder, missing);
            scan.frames.push_back(std::move(frame));
        }
    }
    fresco::refuse_missing(missing, "each frame needs color, depth and pose");
    if (scan.frames.empty())
        throw fresco::MissingInput(path.string() + ": the sequences hold no frames; expected frame-000000.color.png (or .jpg), "
                                                   "frame-000000.depth.png, frame-000000.pose.txt, …");
    return scan;
}
