#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/relief.h>
#include <fresco/run_context.h>
#include <fresco/texture.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

namespace fresco
{

namespace
{

void write_index(const Texture& texture, const std::filesystem::path& folder)
{
    write_file(folder / "texture.json", to_json(Value::Map{{"values", texture.values},
                                                           {"atlas", texture.atlas},
                                                           {"layers", texture.layers.size()},
                                                           {"size_px", texture.size_px()}},
                                                1));
}

constexpr std::int64_t any_size = -1;

/// The raster of that name, as high as it is wide. Throws Error naming its file.
template <class T>
Raster<T> read_square(const ArtifactFolder& folder, const std::string& name, int channels, std::int64_t size_px = any_size)
{
    auto raster = detail::read_npy_or_packed<T>(folder.path, name, channels);
    const std::int64_t expected = size_px == any_size ? raster.width : size_px;
    if (raster.width != expected || raster.height != expected)
        throw Error(fmt::format("{}: is {}x{}; expected {} texels a side", detail::npy_or_packed(folder.path, name).string(),
                                raster.width, raster.height, expected));
    return raster;
}

}  // namespace

void Texture::save(const ArtifactFolder& folder) const
{
    write_index(*this, folder.path);
    for (std::size_t i = 0; i < layers.size(); ++i)
        detail::write_packed(folder.path, fmt::format("layer_{}", i), layers[i]);
    detail::write_packed(folder.path, "seen", seen);
}

void Texture::write_exchange(const Exchange& to) const
{
    write_index(*this, to.folder.path);
    for (std::size_t i = 0; i < layers.size(); ++i)
        write_npy(to.folder.path / fmt::format("layer_{}.npy", i), layers[i]);
    write_npy(to.folder.path / "seen.npy", seen);
}

std::shared_ptr<Texture> Texture::load(const ArtifactFolder& folder)
{
    const detail::JsonFile file(folder.path / "texture.json");
    auto texture = std::make_shared<Texture>();
    texture->values = file["values"].text();
    texture->atlas = file["atlas"].text();
    const std::int64_t layers = file["layers"].integer(1, 16);
    const std::int64_t size = file["size_px"].integer(1);
    for (std::int64_t i = 0; i < layers; ++i)
        // Each layer is half as wide as the one before.
        texture->layers.push_back(read_square<float>(folder, fmt::format("layer_{}", i), 3, size >> i));
    texture->seen = read_square<std::uint8_t>(folder, "seen", 1, size);
    return texture;
}

std::vector<ExchangeForm> Texture::exchange_forms()
{
    return {{.files = {"texture.json"}, .taken_in_place = false, .made_in_place = false}};
}

void TexturedMesh::save(const ArtifactFolder& folder) const
{
    mesh.save(folder);
    image.save(folder);
}

std::shared_ptr<TexturedMesh> TexturedMesh::load(const ArtifactFolder& folder)
{
    auto result = std::make_shared<TexturedMesh>();
    result->mesh = std::move(*Mesh::load(folder));
    result->image = std::move(*Image::load(folder));
    return result;
}

std::vector<ExchangeForm> TexturedMesh::exchange_forms()
{
    std::vector<ExchangeForm> forms = Image::exchange_forms();
    for (ExchangeForm& form : forms)
    {
        form.files.emplace_back("mesh.ply");
        form.is_folder = true;
    }
    return forms;
}

void TexturedMesh::write_exchange(const Exchange& to) const
{
    mesh.save(to.folder);
    image.write_exchange(to);
}

std::shared_ptr<TexturedMesh> TexturedMesh::from_exchange(const Exchange& from)
{
    auto result = std::make_shared<TexturedMesh>();
    result->mesh = std::move(*Mesh::load(from.folder));
    if (result->mesh.texcoords.empty())
        throw Error((from.folder.path / "mesh.ply").string() +
                    ": a textured mesh needs texcoords: a list property texcoord per face");
    result->image = std::move(*Image::from_exchange(from));
    return result;
}

int painted_size_px(int size_px, int laid_out_px, std::string_view source, RunContext& run)
{
    constexpr int least = 16;
    constexpr int most = 16384;
    const int size = size_px == 0 ? laid_out_px : size_px;
    if (size == 0)
        throw Error(
            fmt::format("the texture size is unknown: {} came without one; set size_px, or lay the mesh out with an atlas.* "
                        "stage (atlas.model keeps its texcoords)",
                        source));
    if (size < least || size > most)
        throw Error(fmt::format("a texture of {} texels a side; expected {} to {}: set size_px{}", size, least, most,
                                size_px == 0 ? " of the atlas.* stage" : ""));
    if (laid_out_px > 0 && size != laid_out_px)
        run.warning(fmt::format("size_px is {}, but {} came from an atlas for {}, whose gutters are {} times as wide now: leave "
                                "size_px out here, and set it at the atlas.* stage",
                                size, source, laid_out_px, number_text(std::round(100.0 * size / laid_out_px) / 100)));
    return size;
}

void sample_bilinear(const RasterF& texture, float u, float v, float* out)
{
    const float x = std::clamp(u * static_cast<float>(texture.width) - 0.5F, 0.0F, static_cast<float>(texture.width - 1));
    const float y = std::clamp((1 - v) * static_cast<float>(texture.height) - 0.5F, 0.0F, static_cast<float>(texture.height - 1));
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, texture.width - 1);
    const int y1 = std::min(y0 + 1, texture.height - 1);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    for (int c = 0; c < texture.channels; ++c)
    {
        const float top = texture.at(x0, y0, c) * (1 - fx) + texture.at(x1, y0, c) * fx;
        const float bottom = texture.at(x0, y1, c) * (1 - fx) + texture.at(x1, y1, c) * fx;
        out[c] = top * (1 - fy) + bottom * fy;
    }
}
namespace
{

constexpr float steps = 65534;
constexpr float scale_steps = 256;
constexpr float shift_steps = 255;
constexpr float no_shift = 128;
constexpr int place_values = 4;
constexpr std::uint16_t no_place = 0xffff;
constexpr float turn = 2 * std::numbers::pi_v<float>;

std::uint16_t rounded(float share)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * steps));
}

}  // namespace

std::optional<SourceMap::Place> SourceMap::place(int x, int y) const
{
    const std::uint16_t* value = &places.at(x, y);
    if (value[0] == no_place)
        return std::nullopt;
    const auto share = [&](int i) { return static_cast<float>(value[i]) / steps; };
    const std::uint8_t* const moved = &shifts.at(x, y);
    const auto shift = [moved](int i) { return (static_cast<float>(moved[i]) - no_shift) / shift_steps; };
    return Place{{share(0) * static_cast<float>(picture_width), share(1) * static_cast<float>(picture_height)},
                 share(2) * turn,
                 static_cast<float>(value[3]) / scale_steps,
                 {shift(0), shift(1), shift(2)}};
}

void SourceMap::clear(int size_px)
{
    places = Raster16(size_px, size_px, place_values, no_place);
    shifts = Raster8(size_px, size_px, 3, static_cast<std::uint8_t>(no_shift));
}

void SourceMap::set_place(int x, int y, const Place& place)
{
    std::uint16_t* value = &places.at(x, y);
    value[0] = rounded(place.at.x / static_cast<float>(picture_width));
    value[1] = rounded(place.at.y / static_cast<float>(picture_height));
    const float turns = place.angle / turn;
    value[2] = rounded(turns - std::floor(turns));
    value[3] = static_cast<std::uint16_t>(std::lround(std::clamp(place.scale * scale_steps, 1.0F, 65535.0F)));
    const auto step = [](float shift)
    { return static_cast<std::uint8_t>(std::lround(std::clamp(shift * shift_steps + no_shift, 0.0F, 255.0F))); };
    std::uint8_t* const moved = &shifts.at(x, y);
    moved[0] = step(place.shift.x);
    moved[1] = step(place.shift.y);
    moved[2] = step(place.shift.z);
}

void SourceMap::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / "source_map.json", to_json(Value::Map{{"atlas", atlas},
                                                                   {"picture_width", picture_width},
                                                                   {"picture_height", picture_height},
                                                                   {"pixels_per_texel", static_cast<double>(pixels_per_texel)}},
                                                        1));
    detail::write_packed(folder.path, "places", places);
    detail::write_packed(folder.path, "shifts", shifts);
}

std::shared_ptr<SourceMap> SourceMap::load(const ArtifactFolder& folder)
{
    const detail::JsonFile file(folder.path / "source_map.json");
    auto result = std::make_shared<SourceMap>();
    result->atlas = file["atlas"].text();
    result->picture_width = static_cast<int>(file["picture_width"].integer(1, std::numeric_limits<int>::max()));
    result->picture_height = static_cast<int>(file["picture_height"].integer(1, std::numeric_limits<int>::max()));
    result->pixels_per_texel = static_cast<float>(file["pixels_per_texel"].amount());
    if (!(result->pixels_per_texel > 0))
        file->fail("pixels_per_texel", "expected a number above 0");
    result->places = read_square<std::uint16_t>(folder, "places", place_values);
    result->shifts = read_square<std::uint8_t>(folder, "shifts", 3, result->size_px());
    return result;
}

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
    detail::write_packed(folder.path, "normals", normals);
    detail::write_packed(folder.path, "roughness", roughness);
}

std::shared_ptr<Relief> Relief::load(const ArtifactFolder& folder)
{
    auto result = std::make_shared<Relief>();
    result->atlas = detail::JsonFile(folder.path / "relief.json")["atlas"].text();
    result->normals = read_square<std::uint16_t>(folder, "normals", 3);
    result->roughness = read_square<std::uint8_t>(folder, "roughness", 1, result->size_px());
    return result;
}

}  // namespace fresco
