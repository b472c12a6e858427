#include "mixture.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <array>
#include <filesystem>

using namespace fresco;

namespace
{
constexpr std::array pictures{std::pair{"photo", &Mixture::photo}, std::pair{"colors", &Mixture::colors},
                              std::pair{"painted", &Mixture::painted}};
}  // namespace

void Mixture::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / "mixture.json", to_json(Value::Map{{"atlas", atlas}, {"color", color}, {"strokes", strokes}}, 1));
    for (const auto& [name, picture] : pictures)
    {
        std::filesystem::create_directory(folder.path / name);
        Image(this->*picture).save({folder.path / name, folder.store});
    }
}

std::shared_ptr<Mixture> Mixture::load(const ArtifactFolder& folder)
{
    const auto file = folder.path / "mixture.json";
    const Value root = parse_json(read_text_file(file), file.string());
    auto result = std::make_shared<Mixture>();
    result->atlas = root.at("atlas").as_string();
    result->color = root.at("color").as_double();
    result->strokes = root.at("strokes").as_double();
    for (const auto& [name, picture] : pictures)
    {
        Raster8& pixels = (*result).*picture;
        pixels = Image::load({folder.path / name, folder.store})->pixels;
        if (pixels.channels != 3 || pixels.width != pixels.height || pixels.width != result->photo.width)
            throw Error((folder.path / name).string() + ": expected a square RGB picture of the size of the photo's");
    }
    return result;
}
