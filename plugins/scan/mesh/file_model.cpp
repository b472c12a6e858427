#include "file_model.h"

#include "mtl.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/text.h>
#include <fresco/texturing/texture_pictures.h>
#include <fresco/wording.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

namespace scan_mesh
{

namespace fs = std::filesystem;

namespace
{

using fresco::MeshMaterials;
using fresco::ModelMaterial;

fresco::Vec3f linear_color(const std::array<double, 3>& displayed)
{
    const auto light = [](double v)
    {
        return static_cast<float>(
            fresco::texturing::to_linear(static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 1.0) * 255))));
    };
    return {light(displayed[0]), light(displayed[1]), light(displayed[2])};
}

/// Fits the materials that an OBJ or PLY names to its mesh.
class MaterialReader
{
  public:
    MaterialReader(const fs::path& file, const MeshMaterials& named, FileModel& model)
        : file_(file), folder_(file, model), named_(named), model_(model)
    {
    }

    void read_obj()
    {
        read_libraries();
        for (std::size_t face = 0; face < model_.mesh.triangles.size(); ++face)
        {
            const bool has_texcoords =
                named_.has_texcoords.empty() ? !model_.mesh.texcoords.empty() : named_.has_texcoords[face] != 0;
            const MtlMaterial* const mtl = definition(named_.of_face[face]);
            const bool has_picture = mtl != nullptr && !mtl->picture.empty();
            const int tile = has_picture && has_texcoords ? placed(face, *mtl) : no_picture;
            without_texcoords_ += has_picture && !has_texcoords ? 1 : 0;
            const auto [found, is_new] =
                numbers_.try_emplace({named_.of_face[face], tile}, static_cast<std::uint32_t>(model_.materials.size()));
            if (is_new)
                model_.materials.push_back(obj_material(mtl, tile));
            model_.material_of_face.push_back(found->second);
        }
        if (without_texcoords_ > 0)
            model_.warnings.push_back(fmt::format(
                "{} faces have a picture but no texture coordinates: they take the material's color Kd", without_texcoords_));
        if (outside_tiles_ > 0)
            model_.warnings.push_back(
                fmt::format("{} faces lie outside the UDIM tiles {} to {}: they take the material's color Kd", outside_tiles_,
                            first_tile, first_tile + tiles - 1));
    }

    void read_ply()
    {
        if (!named_.files.empty() && model_.mesh.texcoords.empty())
            model_.warnings.emplace_back("the file names a picture but has no texture coordinates: the picture is not used");
        if (named_.files.size() > 1 && named_.of_face.empty())
            model_.warnings.push_back(fmt::format(
                "the file names {} pictures but has no face property texnumber: the first is used", named_.files.size()));
        if (named_.names.size() > most_face_colors)
            throw fresco::Error(fmt::format("{}: the faces have {} colors; expected at most {}: give the colors to the vertices "
                                            "(MeshLab: Transfer Color: Face to Vertex){}",
                                            file_.string(), named_.names.size(), most_face_colors, shape_only));
        std::map<std::uint32_t, std::uint32_t> numbers;
        for (std::size_t face = 0; face < model_.mesh.triangles.size(); ++face)
        {
            const std::uint32_t first = named_.files.empty() ? MeshMaterials::none : 0;
            const std::uint32_t picture = named_.of_face.empty() ? first : named_.of_face[face];
            const auto [found, is_new] = numbers.try_emplace(picture, static_cast<std::uint32_t>(model_.materials.size()));
            if (is_new)
                model_.materials.push_back(ply_material(picture));
            model_.material_of_face.push_back(found->second);
        }
    }

  private:
    static constexpr std::size_t most_face_colors = 4096;
    // In place of the number of a UDIM tile.
    static constexpr int no_tile = 0;
    static constexpr int no_picture = -1;
    static constexpr int first_tile = 1001;
    static constexpr int tiles = 1000;
    static constexpr float rows_of_tiles = 100;
    static constexpr std::string_view udim = "<UDIM>";

    std::string place_of(const fresco::MeshFileName& name, const std::string& keyword) const
    {
        return fmt::format("{}:{}: {}", file_.string(), name.line, keyword);
    }

    /// ModelFolder::find. Without the file: none, and a warning that ends in `otherwise`.
    std::optional<fs::path> found(std::string_view name, const std::string& place, std::string_view otherwise,
                                  const fs::path& folder = {})
    {
        try
        {
            return folder_.find(name, place, otherwise, folder);
        }
        catch (const fresco::MissingInput& error)
        {
            model_.warnings.emplace_back(error.what());
            return std::nullopt;
        }
    }

    /// mtllib may be followed by one name with spaces or by several names.
    std::vector<std::string> library_names(const fresco::MeshFileName& library) const
    {
        constexpr std::size_t most_names = 64;
        std::vector<std::string> names;
        if (folder_.has(library.name))
            return {library.name};
        fresco::Words words(library.name);
        for (auto name = words.next(); !name.empty() && names.size() < most_names; name = words.next())
            names.emplace_back(name);
        const bool is_list = names.size() > 1 && std::ranges::any_of(names, [&](const auto& name) { return folder_.has(name); });
        return is_list ? names : std::vector<std::string>{library.name};
    }

    void read_libraries()
    {
        bool are_all_there = true;
        std::set<std::string> seen;
        for (const auto& library : named_.files)
        {
            if (!seen.insert(library.name).second)
                continue;
            for (const std::string& name : library_names(library))
            {
                const auto mtl = found(name, place_of(library, "mtllib"), ": until then its materials are white");
                are_all_there = are_all_there && mtl.has_value();
                if (!mtl)
                    continue;
                model_.files_read.push_back(*mtl);
                for (MtlMaterial& material : parse_mtl(fresco::read_text_file(*mtl), mtl->string()))
                {
                    warn_of_color(material, *mtl);
                    materials_.try_emplace(material.name, std::move(material), *mtl);
                }
            }
        }
        std::vector<fresco::MeshFileName> undefined;
        std::ranges::copy_if(named_.names, std::back_inserter(undefined),
                             [&](const auto& name) { return !materials_.contains(name.name); });
        if (undefined.empty() || !are_all_there)
            return;
        const std::string more = undefined.size() > 1 ? fmt::format(", and {} more are missing", undefined.size() - 1) : "";
        const std::string problem =
            fmt::format("{}: no file that mtllib names has \"newmtl {}\"{}; export the OBJ with its materials",
                        place_of(undefined[0], "usemtl"), undefined[0].name, more);
        model_.warnings.push_back(problem + ": until then they are white");
    }

    /// Rounding may lead out of the range by little.
    void warn_of_color(const MtlMaterial& material, const fs::path& mtl)
    {
        const auto [least, most] = std::ranges::minmax(material.color);
        if (least < -0.01 || most > 1.01)
            model_.warnings.push_back(fmt::format("{}: the color Kd {} of \"{}\" is cut to 0 to 1", mtl.string(),
                                                  fmt::join(material.color, " "), material.name));
    }

    const MtlMaterial* definition(std::uint32_t name) const
    {
        const auto found = name == MeshMaterials::none ? materials_.end() : materials_.find(named_.names[name].name);
        return found == materials_.end() ? nullptr : &found->second.first;
    }

    /// Places the texcoords of a face in its picture. Returns the number of the face's UDIM tile, or one of the above.
    int placed(std::size_t face, const MtlMaterial& mtl)
    {
        const auto uv = std::span(model_.mesh.texcoords).subspan(3 * face, 3);
        for (fresco::Vec2f& corner : uv)
            corner = {static_cast<float>(double{corner.x} * mtl.scale.x + mtl.offset.x),
                      static_cast<float>(double{corner.y} * mtl.scale.y + mtl.offset.y)};
        if (!is_tiled(mtl))
            return no_tile;
        const float column = std::floor((uv[0].x + uv[1].x + uv[2].x) / 3);
        const float row = std::floor((uv[0].y + uv[1].y + uv[2].y) / 3);
        if (!(column >= 0 && column < 10 && row >= 0 && row < rows_of_tiles))
        {
            ++outside_tiles_;
            return no_picture;
        }
        for (fresco::Vec2f& corner : uv)
            corner = {corner.x - column, corner.y - row};
        return first_tile + static_cast<int>(column) + 10 * static_cast<int>(row);
    }

    /// Whether the picture is one of UDIM tiles: its name has "<UDIM>", or 1001 and other tiles lie beside it.
    bool is_tiled(const MtlMaterial& mtl)
    {
        const auto [known, is_new] = tiled_.try_emplace(&mtl, mtl.picture.find(udim) != std::string::npos);
        if (!is_new || known->second || with_tile(mtl.picture, "") == mtl.picture)
            return known->second;
        // Other materials' pictures are no tiles of this one.
        std::set<std::string> others;
        for (const auto& [name, material] : materials_)
            others.insert(material.first.picture);
        for (int tile = first_tile + 1; tile < first_tile + tiles; ++tile)
            if (others.contains(with_tile(mtl.picture, std::to_string(tile))))
                return false;
        const auto first = picture_file(mtl, mtl.picture);
        if (!first)
            return false;
        const auto beside = [&](const std::string& number)
        { return first->parent_path() / with_tile(first->filename().string(), number); };
        model_.looked_for.push_back(beside("????"));
        for (int tile = first_tile + 1; tile < first_tile + tiles && !known->second; ++tile)
            known->second = fs::is_regular_file(beside(std::to_string(tile)));
        if (known->second)
            model_.messages.push_back("\"" + mtl.picture + "\" is read with the UDIM tiles beside it");
        return known->second;
    }

    /// The name of another tile: with this number for "<UDIM>" or for 1001.
    static std::string with_tile(std::string name, const std::string& number)
    {
        const auto is_digit = [&](std::size_t at) { return at < name.size() && name[at] >= '0' && name[at] <= '9'; };
        if (const auto at = name.find(udim); at != std::string::npos)
            return name.replace(at, udim.size(), number);
        const auto at = name.rfind(std::to_string(first_tile));
        return at == std::string::npos || is_digit(at - 1) || is_digit(at + 4) ? name : name.replace(at, 4, number);
    }

    std::optional<fs::path> picture_file(const MtlMaterial& mtl, const std::string& name)
    {
        const fs::path& mtl_file = materials_.at(mtl.name).second;
        const auto [known, is_new] = found_pictures_.try_emplace({mtl_file.parent_path(), name});
        if (is_new)
            known->second = found(name, fmt::format("{}:{}: map_Kd", mtl_file.string(), mtl.picture_line),
                                  ": until then its faces have the color Kd", mtl_file.parent_path());
        return known->second;
    }

    ModelMaterial obj_material(const MtlMaterial* mtl, int tile)
    {
        ModelMaterial material;
        material.vertex_colors = !model_.mesh.colors.empty();
        if (mtl == nullptr)
            return material;
        material.name = mtl->name;
        const auto picture = tile == no_picture ? std::nullopt
                             : tile == no_tile  ? picture_file(*mtl, mtl->picture)
                                                : picture_file(*mtl, with_tile(mtl->picture, std::to_string(tile)));
        if (picture)
        {
            material.picture = picture_number(*picture);
            material.wrap_u = material.wrap_v = mtl->clamp || tile != no_tile ? fresco::Wrap::clamp : fresco::Wrap::repeat;
            material.vertex_colors = false;
        }
        else if (!material.vertex_colors)
            material.color = linear_color(mtl->color);
        return material;
    }

    ModelMaterial ply_material(std::uint32_t picture)
    {
        ModelMaterial material;
        material.vertex_colors = !model_.mesh.colors.empty();
        if (!named_.names.empty())
        {
            material.name = named_.names[picture].name;
            const auto rgb = static_cast<unsigned>(std::stoul(material.name.substr(1), nullptr, 16));
            material.color = linear_color({(rgb >> 16U) / 255.0, (rgb >> 8U & 255U) / 255.0, (rgb & 255U) / 255.0});
            return material;
        }
        if (picture == MeshMaterials::none || model_.mesh.texcoords.empty())
            return material;
        const auto& name = named_.files.at(picture);
        material.name = name.name;
        if (const auto file = found(name.name, place_of(name, "comment TextureFile"), ": until then its faces have no picture"))
        {
            material.picture = picture_number(*file);
            material.vertex_colors = false;
        }
        return material;
    }

    int picture_number(const fs::path& file)
    {
        const auto found = std::ranges::find(model_.pictures, file, &FilePicture::file);
        if (found != model_.pictures.end())
            return static_cast<int>(found - model_.pictures.begin());
        model_.pictures.push_back({file.string(), file, {}});
        model_.files_read.push_back(file);
        return static_cast<int>(model_.pictures.size() - 1);
    }

    const fs::path& file_;
    fresco::recordings::ModelFolder folder_;
    const MeshMaterials& named_;
    FileModel& model_;
    std::map<std::string, std::pair<MtlMaterial, fs::path>> materials_;
    std::map<std::pair<std::uint32_t, int>, std::uint32_t> numbers_;  ///< The materials, by name and tile.
    std::map<std::pair<fs::path, std::string>, std::optional<fs::path>> found_pictures_;
    std::map<const MtlMaterial*, bool> tiled_;
    std::size_t without_texcoords_ = 0;
    std::size_t outside_tiles_ = 0;
};

void number_objects(const MeshMaterials& named, FileModel& model)
{
    ObjectNumbers objects;
    std::vector<std::uint32_t> number_of_group;
    std::string object;
    for (const fresco::MeshGroup& group : named.groups)
    {
        const std::string path = ObjectNumbers::path(group.is_object ? "" : object, group.name);
        object = group.is_object ? path : object;
        number_of_group.push_back(objects.number_of(path));
    }
    if (objects.count() < 2)
        return;
    model.objects = objects.paths();
    for (const std::uint32_t group : named.group_of_face)
        model.object_of_face.push_back(group == MeshMaterials::none ? ObjectNumbers::most_objects : number_of_group[group]);
}

}  // namespace

std::uint32_t ObjectNumbers::number_of(const std::string& path)
{
    if (path.empty() || (numbers_.size() == most_objects && !numbers_.contains(path)))
        return most_objects;
    return numbers_.try_emplace(path, static_cast<std::uint32_t>(numbers_.size())).first->second;
}

std::vector<std::string> ObjectNumbers::paths() const
{
    std::vector<std::string> result(numbers_.size());
    for (const auto& [path, number] : numbers_)
        result[number] = path;
    return result;
}

std::string ObjectNumbers::path(const std::string& outer, std::string_view name)
{
    constexpr std::size_t most_bytes = 256;
    if (name.empty() || name.size() > most_bytes)
        return outer;
    // Stored names are UTF-8; two that differ only in bytes that are not become one here already.
    const std::string stored = fresco::parse_json(fresco::to_json(fresco::Value(std::string(name))), "a name").as_string();
    name = stored;
    if (outer.empty() || outer.size() > most_bytes)
        return std::string(name);
    return outer == name || outer.ends_with("/" + std::string(name)) ? outer : outer + "/" + std::string(name);
}

std::string_view suffix_of(std::span<const std::byte> picture)
{
    const std::string_view text(reinterpret_cast<const char*>(picture.data()), picture.size());
    const auto has = [&](std::size_t at, std::string_view mark) { return text.size() > at && text.substr(at).starts_with(mark); };
    if (has(0, "\x89PNG"))
        return ".png";
    if (has(0, "\xFF\xD8\xFF"))
        return ".jpg";
    if (has(0, "RIFF") && has(8, "WEBP"))
        return ".webp";
    if (has(0, "BM"))
        return ".bmp";
    return has(4, "ftyp") ? ".heic" : "";
}

std::vector<std::byte> without_profile(std::vector<std::byte> picture)
{
    const std::string_view kind = suffix_of(picture);
    const std::string_view text(reinterpret_cast<const char*>(picture.data()), picture.size());
    // Segments and chunks of other kinds are skipped.
    constexpr std::string_view mark("ICC_PROFILE\0", 12);
    for (auto at = text.find(mark, 4); kind == ".jpg" && at != std::string_view::npos; at = text.find(mark, at + 1))
        if (text.substr(at - 4, 2) == "\xFF\xE2")
            picture[at - 3] = std::byte{0xEF};
    if (kind == ".webp" && text.size() > 34 && text.substr(12, 4) == "VP8X" && text.substr(30, 4) == "ICCP")
        picture[30] = std::byte{'i'};
    if (const auto at = text.find("iCCP"); kind == ".png" && at < text.find("IDAT"))
    {
        std::size_t length = 0;
        for (std::size_t i = at - 4; i < at; ++i)
            length = length << 8U | std::to_integer<std::size_t>(picture[i]);
        if (length < text.size() - at - 4)
            picture.erase(picture.begin() + static_cast<std::ptrdiff_t>(at - 4),
                          picture.begin() + static_cast<std::ptrdiff_t>(std::min(at + 8 + length, text.size())));
    }
    return picture;
}

FileModel read_file_model(const fs::path& file, bool with_materials)
{
    const std::string extension = fresco::lower_extension(file);
    if (extension == ".glb" || extension == ".gltf")
        return read_gltf_model(file, with_materials);
    if (extension != ".ply" && extension != ".obj")
        throw fresco::Error(file.string() + ": unknown extension; a model is read from a .ply, .obj, .glb or .gltf file");
    FileModel model;
    MeshMaterials named;
    model.mesh = fresco::read_mesh(file, {}, &model.report, &named);
    number_objects(named, model);
    if (with_materials)
    {
        MaterialReader reader(file, named, model);
        extension == ".obj" ? reader.read_obj() : reader.read_ply();
    }
    else
    {
        model.materials.emplace_back().vertex_colors = !model.mesh.colors.empty();
        model.material_of_face.assign(model.mesh.triangles.size(), 0);
    }
    model.split_vertices = extension == ".ply" && !model.mesh.texcoords.empty();
    return model;
}

}  // namespace scan_mesh
