#include "replica_scene.h"

#include <fresco/error.h>
#include <fresco/matrix_text.h>
#include <fresco/recording.h>
#include <fresco/recordings/json_record.h>
#include <fresco/recordings/text_records.h>

#include <charconv>
#include <optional>

namespace replica
{
namespace
{

namespace fs = std::filesystem;

std::optional<long> number_behind(std::string_view stem, std::string_view prefix)
{
    if (!stem.starts_with(prefix) || stem.size() == prefix.size())
        return std::nullopt;
    const auto digits = stem.substr(prefix.size());
    long number = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (code != std::errc{} || end != digits.data() + digits.size() || digits.front() == '-')
        return std::nullopt;
    return number;
}

void take(fs::path& place, const fs::path& file)
{
    if (!place.empty())
        throw fresco::Error(file.string() + ": there is another picture of this number, " + place.filename().string() +
                            "; remove one");
    place = file;
}

fs::path own_path(const fs::path& path)
{
    return fs::weakly_canonical(path);
}

}  // namespace

SceneCamera parse_camera(std::string_view text, std::string_view source)
{
    const auto root = fresco::parse_json(text, source);
    const std::string name(source);
    const auto* camera = root.find("camera");
    if (camera == nullptr)
        throw fresco::Error(name + R"(: expected {"camera": {"w": …, "h": …, "fx": …, "fy": …, "cx": …, "cy": …, "scale": …}})");
    const fresco::recordings::JsonRecord record(*camera, name + ": camera");
    const double scale = record.number("scale");
    if (!(scale >= 1 && scale <= 1e6))
        record.fail("scale", "must be steps of depth per meter, from 1 to 1000000");
    return {{record.pixels("w"), record.pixels("h"), record.number("fx"), record.number("fy"), record.number("cx") + 0.5,
             record.number("cy") + 0.5},
            1 / scale};
}

std::vector<fresco::RigidTransform> parse_trajectory(std::string_view text, std::string_view source)
{
    fresco::recordings::LineReader lines(text, source);
    std::vector<fresco::RigidTransform> poses;
    while (const auto line = lines.next())
        poses.push_back(fresco::rigid_transform(fresco::parse_numbers(*line, 16, lines.place()), lines.place()));
    return poses;
}

std::map<long, PicturePair> list_pictures(const fs::path& folder)
{
    std::map<long, PicturePair> pictures;
    if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
        {
            const auto& file = entry.path();
            const auto stem = file.stem().string(), ending = file.extension().string();
            if (const auto number = number_behind(stem, "frame"); number && (ending == ".jpg" || ending == ".png"))
                take(pictures[*number].color, file);
            else if (const auto of_depth = number_behind(stem, "depth"); of_depth && ending == ".png")
                take(pictures[*of_depth].depth, file);
        }
    if (pictures.empty())
        throw fresco::MissingInput(folder.string() + ": no pictures; expected frame000000.jpg, depth000000.png, …");
    return pictures;
}

std::vector<fresco::recordings::RegisteredView> scene_views(const std::map<long, PicturePair>& pictures,
                                                            const std::vector<fresco::RigidTransform>& trajectory,
                                                            const fs::path& trajectory_file, const SceneCamera& camera, int every)
{
    std::vector<fresco::recordings::RegisteredView> views;
    std::vector<std::string> missing;
    int index = 0;
    for (const auto& [number, pair] : pictures)
    {
        if (index++ % every != 0)
            continue;
        if (pair.color.empty())
            missing.push_back("the color picture beside " + pair.depth.string());
        if (pair.depth.empty())
            missing.push_back("the depth picture beside " + pair.color.string());
        if (static_cast<std::size_t>(number) >= trajectory.size())
            throw fresco::Error(trajectory_file.string() + ": " + std::to_string(trajectory.size()) +
                                " poses, but there are pictures of frame " + std::to_string(number) +
                                "; expected a line for each frame, from frame 0 on: the file is cut, or of another scene");
        fresco::recordings::RegisteredView view;
        view.sequence = "results";
        view.name = pair.color.stem().string();
        view.number = number;
        view.color = pair.color;
        view.depth = pair.depth;
        view.camera = camera.intrinsics;
        view.world_from_camera = trajectory[static_cast<std::size_t>(number)];
        view.depth_unit_m = camera.depth_unit_m;
        view.source = trajectory_file.string() + ":" + std::to_string(number + 1);
        views.push_back(std::move(view));
    }
    fresco::refuse_missing(missing, "each frame needs color and depth");
    return views;
}

fs::path first_file(const std::vector<fs::path>& candidates, std::string_view what)
{
    std::string names;
    for (const auto& candidate : candidates)
    {
        if (fs::is_regular_file(candidate))
            return candidate;
        names += (names.empty() ? "" : " or ") + candidate.string();
    }
    throw fresco::MissingInput(std::string(what) + " is missing; expected " + names);
}

std::vector<fs::path> camera_candidates(const fs::path& path)
{
    return {path / "cam_params.json", own_path(path).parent_path() / "cam_params.json"};
}

std::vector<fs::path> mesh_candidates(const fs::path& path)
{
    const auto own = own_path(path);
    return {path / "mesh.ply", own.parent_path() / (own.filename().string() + "_mesh.ply")};
}

}  // namespace replica
