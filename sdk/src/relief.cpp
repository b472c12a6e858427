#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/relief.h>

#include <algorithm>
#include <cmath>

namespace fresco
{

namespace
{
constexpr float half = 65535 / 2.0F;
}  // namespace

bool Relief::has_normal(std::size_t texel) const
{
    const std::uint16_t* const n = &normals.values[3 * texel];
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

Vec3f Relief::normal(std::size_t texel) const
{
    const std::uint16_t* const n = &normals.values[3 * texel];
    const auto component = [n](int i) { return static_cast<float>(n[i]) / half - 1; };
    return {component(0), component(1), component(2)};
}

void Relief::set_normal(std::size_t texel, Vec3f normal)
{
    const auto step = [](float v) { return static_cast<std::uint16_t>(std::lround((std::clamp(v, -1.0F, 1.0F) + 1) * half)); };
    std::uint16_t* const n = &normals.values[3 * texel];
    n[0] = step(normal.x);
    n[1] = step(normal.y);
    n[2] = step(normal.z);
}

void Relief::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / "relief.json", to_json(Value::Map{{"atlas", atlas}}, 1));
    write_npy(folder.path / "normals.npy", normals);
    write_npy(folder.path / "roughness.npy", roughness);
}

std::shared_ptr<Relief> Relief::load(const ArtifactFolder& folder)
{
    auto result = std::make_shared<Relief>();
    result->atlas = detail::JsonFile(folder.path / "relief.json")["atlas"].text();
    const auto normals_file = folder.path / "normals.npy";
    result->normals = detail::read_raster<std::uint16_t>(normals_file, 3);
    if (result->normals.width != result->normals.height)
        throw Error(normals_file.string() + ": expected a square map");
    const auto roughness_file = folder.path / "roughness.npy";
    result->roughness = detail::read_raster<std::uint8_t>(roughness_file, 1);
    if (result->roughness.width != result->size_px() || result->roughness.height != result->size_px())
        throw Error(roughness_file.string() + ": is not of the normals' size");
    return result;
}

}  // namespace fresco
