#include "keyframes.h"

#include <fresco/error.h>
#include <fresco/recording.h>
#include <fresco/recordings/json_record.h>

#include <algorithm>

namespace polycam
{
namespace fs = std::filesystem;
using fresco::recordings::RegisteredView;

KeyframeFolders keyframe_folders(const fs::path& scan, bool recorded)
{
    const auto keyframes = scan / "keyframes";
    KeyframeFolders corrected{keyframes / "corrected_cameras", keyframes / "corrected_images", true};
    if (!recorded && fs::is_directory(corrected.cameras) && fs::is_directory(corrected.images))
        return corrected;
    KeyframeFolders plain{keyframes / "cameras", keyframes / "images", false};
    for (const auto& folder : {plain.cameras, plain.images})
        if (!fs::is_directory(folder))
            throw fresco::MissingInput(folder.string() +
                                       ": no such folder; expected Polycam's raw data export, with keyframes/cameras, "
                                       "keyframes/images and keyframes/depth in it");
    return plain;
}

void parse_camera(std::string_view text, const fs::path& source, RegisteredView& view)
{
    const auto root = fresco::parse_json(text, source.string());
    const fresco::recordings::JsonRecord record(root, source.string());
    view.camera = {record.pixels("width"), record.pixels("height"), record.number("fx"),
                   record.number("fy"),    record.number("cx"),     record.number("cy")};
    std::vector<double> matrix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
        {
            const double value = record.number("t_" + std::to_string(row) + std::to_string(column));
            matrix[4 * row + column] = column == 1 || column == 2 ? -value : value;
        }
    view.world_from_camera = fresco::rigid_transform(matrix, source.string() + ": t_00 to t_23");
    view.source = source.string();
}

std::vector<RegisteredView> list_keyframes(const fs::path& scan, const KeyframeFolders& folders)
{
    std::vector<RegisteredView> views;
    std::vector<std::string> missing;
    for (const auto& entry : fs::directory_iterator(folders.cameras))
    {
        if (entry.path().extension() != ".json")
            continue;
        const auto stem = entry.path().stem().string();
        RegisteredView view;
        fresco::recordings::name_by_picture(view, fs::path("keyframes") / stem);
        view.source = entry.path().string();
        view.color = folders.images / (stem + ".jpg");
        view.depth = scan / "keyframes" / "depth" / (stem + ".png");
        for (const auto& picture : {view.color, view.depth})
            if (!fs::is_regular_file(picture))
                missing.push_back(picture.string());
        views.push_back(std::move(view));
    }
    if (views.empty())
        throw fresco::MissingInput(folders.cameras.string() +
                                   ": no cameras; expected a file such as 638443502.json for each keyframe");
    std::ranges::sort(missing);
    fresco::refuse_missing(missing, "each camera has an image and a depth picture of its name");
    fresco::recordings::order_by_name(views);
    return views;
}

fresco::RigidTransform parse_alignment(std::string_view text, std::string_view source)
{
    const auto root = fresco::parse_json(text, source);
    const auto* found = root.find("alignmentTransform");
    const std::string place = std::string(source) + ": alignmentTransform";
    if (found == nullptr || !found->is_list() || found->as_list().size() != 16)
        throw fresco::Error(place + ": 16 numbers were expected");
    std::vector<double> matrix(16);
    for (std::size_t i = 0; i < 16; ++i)
    {
        const auto& value = found->as_list()[i];
        if (!value.is_number())
            throw fresco::Error(place + ": 16 numbers were expected");
        matrix[4 * (i % 4) + i / 4] = value.as_double();
    }
    return fresco::rigid_transform(matrix, place);
}

}  // namespace polycam
