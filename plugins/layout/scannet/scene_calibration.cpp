#include "scene_calibration.h"

#include <fresco/error.h>
#include <fresco/recordings/layout.h>
#include <fresco/text.h>

namespace fs = std::filesystem;
using namespace fresco::recordings;

namespace scannet
{

namespace
{

using Properties = std::map<std::string, std::string>;

double number_property(const Properties& properties, const std::string& key, const fs::path& file)
{
    const auto found = properties.find(key);
    if (found == properties.end())
        throw fresco::Error(
            file.string() + ": the property " + key +
            " is missing; expected it there, or a folder intrinsic with intrinsic_color.txt and intrinsic_depth.txt");
    return parse_numbers(found->second, 1, file.string() + ": " + key)[0];
}

CameraMatrix camera_of_properties(const Properties& properties, const std::string& camera, const fs::path& file)
{
    const auto get = [&](const std::string& name) { return number_property(properties, name + "_" + camera, file); };
    return {{get("fx"), 0, get("mx"), 0, 0, get("fy"), get("my"), 0, 0, 0, 1, 0, 0, 0, 0, 1}, file.string()};
}

CameraMatrix camera_of_file(const fs::path& file, fresco::RunContext& run)
{
    run.reads_file(file);
    return {read_matrix_text(file, 4, 4), file.string()};
}

fresco::RigidTransform extrinsic_of_file(const fs::path& file, fresco::RunContext& run)
{
    looks_for(file, run);
    if (!fs::exists(file))
        return {};
    run.reads_file(file);
    return read_rigid_transform(file);
}

/// A number that is cut is another number.
bool is_read(std::string_view key)
{
    return key.ends_with("_color") || key.ends_with("_depth");
}

}  // namespace

Properties parse_properties(std::string_view text, std::string_view source)
{
    Properties properties;
    LineReader lines(text, source, LastLine::any);
    while (const auto line = lines.next())
    {
        if (fresco::trimmed(*line).empty())
            continue;
        const std::string place = lines.place();
        const auto equals = line->find('=');
        if (equals == std::string_view::npos)
            throw fresco::Error(place + ": expected \"key = value\"");
        const std::string key(fresco::trimmed(line->substr(0, equals)));
        if (text.find('\n', static_cast<std::size_t>(line->end() - text.begin())) == std::string_view::npos && is_read(key))
            throw fresco::Error(place + ": the file ends inside the line of " + key +
                                ": it may be truncated; copy it again (if it is complete, add a final newline)");
        if (!properties.emplace(key, fresco::trimmed(line->substr(equals + 1))).second)
            throw fresco::Error(place + ": the property " + key + " appears twice");
    }
    return properties;
}

SceneCalibration read_scene_calibration(const fs::path& path, const fs::path& properties_file, fresco::RunContext& run)
{
    SceneCalibration calibration;
    const fs::path folder = path / "intrinsic";
    looks_for(folder, run);
    if (fs::is_directory(folder))
    {
        calibration.color = camera_of_file(folder / "intrinsic_color.txt", run);
        calibration.depth = camera_of_file(folder / "intrinsic_depth.txt", run);
        const auto rig_from_color = extrinsic_of_file(folder / "extrinsic_color.txt", run);
        const auto rig_from_depth = extrinsic_of_file(folder / "extrinsic_depth.txt", run);
        calibration.depth_from_color = rig_from_depth.inverse() * rig_from_color;
    }
    else if (!properties_file.empty())
    {
        const auto properties = parse_properties(recorded_text(properties_file, run), properties_file.string());
        calibration.color = camera_of_properties(properties, "color", properties_file);
        calibration.depth = camera_of_properties(properties, "depth", properties_file);
    }
    else
        throw fresco::MissingInput(path.string() +
                                   ": no calibration; expected the folder intrinsic or the scene's own .txt file");
    return calibration;
}

}  // namespace scannet
