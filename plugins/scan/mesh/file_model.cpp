#include "file_model.h"

#include "mtl.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/texturing/texture_pictures.h>
#include <fresco/wording.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace scan_mesh
{

namespace fs = std::filesystem;

namespace
{

/// "C:\pictures", "https://…", "file:…": letters before a colon.
bool has_scheme(std::string_view name)
{
    const auto colon = name.find(':');
    return colon != std::string_view::npos && colon > 0 && name.substr(0, colon).find_first_of("/\\ .") == std::string_view::npos;
}

bool is_inside(const fs::path& file, const fs::path& folder)
{
    const auto [in_folder, in_file] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    return in_folder == folder.end() && in_file != file.end();
}

}  // namespace

FileFolder::FileFolder(const fs::path& model) : folder_(model.parent_path().empty() ? fs::path(".") : model.parent_path()) {}

fs::path FileFolder::find(std::string_view name, std::string_view place, std::string_view way_out) const
{
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
    std::string shown(name.substr(0, 200));
    std::ranges::replace_if(shown, is_control, '?');
    const std::string begin = std::string(place) + ": \"" + shown + "\" ";
    if (name.empty() || std::ranges::any_of(name, is_control))
        throw fresco::Error(begin + "is not a file name");
    std::string text(name);
    std::ranges::replace(text, '\\', '/');
    const fs::path relative(text);
    const bool leaves = std::ranges::find(relative, fs::path("..")) != relative.end();
    if (relative.is_absolute() || leaves || has_scheme(name))
        throw fresco::Error(begin + "is outside the model's folder; put the file beside the model and use only its name");
    fs::path file = folder_ / relative;
    std::error_code error;
    if (!fs::is_regular_file(file, error))
        throw fresco::MissingInput(begin + "is not in " + folder_.string() + "; put it there" + std::string(way_out));
    if (!is_inside(fs::canonical(file), fs::canonical(folder_)))
        throw fresco::Error(begin + "is a link to a file outside the model's folder; put the file itself there");
    return file;
}

bool FileFolder::has(std::string_view name) const
{
    try
    {
        return !find(name, "").empty();
    }
    catch (const fresco::Error&)
    {
        return false;
    }
}

namespace
{

using fresco::MeshMaterials;
using fresco::ModelMaterial;

fresco::Vec3f linear_color(const std::array<double, 3>& displayed)
{
    const auto light = [](double v)
    { return static_cast<float>(fresco::texturing::to_linear(static_cast<std::uint8_t>(std::lround(v * 255)))); };
    return {light(displayed[0]), light(displayed[1]), light(displayed[2])};
}

/// Fits the materials that an OBJ or PLY names to its mesh.
class MaterialReader
{
  public:
    MaterialReader(const fs::path& file, const MeshMaterials& named, FileModel& model)
        : file_(file), folder_(file), named_(named), model_(model)
    {
    }

    void read_obj()
    {
        read_libraries();
        std::map<std::pair<std::uint32_t, bool>, std::uint32_t> numbers;
        std::size_t without_texcoords = 0;
        for (std::size_t face = 0; face < model_.mesh.triangles.size(); ++face)
        {
            const bool has_texcoords =
                named_.has_texcoords.empty() ? !model_.mesh.texcoords.empty() : named_.has_texcoords[face] != 0;
            const auto [found, is_new] =
                numbers.try_emplace({named_.of_face[face], has_texcoords}, static_cast<std::uint32_t>(model_.materials.size()));
            const MtlMaterial* const mtl = definition(named_.of_face[face]);
            if (is_new)
                model_.materials.push_back(obj_material(mtl, has_texcoords));
            model_.material_of_face.push_back(found->second);
            if (mtl == nullptr || mtl->picture.empty())
                continue;
            if (!has_texcoords)
                ++without_texcoords;
            for (std::size_t corner = 3 * face; has_texcoords && corner < 3 * face + 3; ++corner)
                place(model_.mesh.texcoords[corner], *mtl);
        }
        if (without_texcoords > 0)
            model_.warnings.push_back(fmt::format(
                "{} faces have a picture but no texture coordinates: they take the material's color Kd", without_texcoords));
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

    std::string place_of(const fresco::MeshFileName& name, const std::string& keyword) const
    {
        return fmt::format("{}:{}: {}", file_.string(), name.line, keyword);
    }

    /// mtllib may be followed by one name with spaces or by several names.
    std::vector<std::string> library_names(const fresco::MeshFileName& library) const
    {
        std::vector<std::string> names;
        for (std::size_t at = 0; at < library.name.size() && !folder_.has(library.name);)
        {
            const std::size_t end = std::min(library.name.find_first_of(" \t", at), library.name.size());
            if (end > at)
                names.push_back(library.name.substr(at, end - at));
            at = end + 1;
        }
        const bool is_list = names.size() > 1 && folder_.has(names.front());
        return is_list ? names : std::vector<std::string>{library.name};
    }

    void read_libraries()
    {
        for (const auto& library : named_.files)
            for (const std::string& name : library_names(library))
            {
                const fs::path mtl = folder_.find(name, place_of(library, "mtllib"), shape_only);
                model_.files_read.push_back(mtl);
                for (MtlMaterial& material : parse_mtl(fresco::read_text_file(mtl), mtl.string()))
                    materials_.try_emplace(material.name, std::move(material), mtl);
            }
        if (named_.files.empty())
            return;
        for (const auto& name : named_.names)
            if (!materials_.contains(name.name))
                throw fresco::Error(place_of(name, "usemtl") + ": no file that mtllib names has \"newmtl " + name.name +
                                    "\"; export the OBJ with its materials" + std::string(shape_only));
    }

    const MtlMaterial* definition(std::uint32_t name) const
    {
        const auto found = name == MeshMaterials::none ? materials_.end() : materials_.find(named_.names[name].name);
        return found == materials_.end() ? nullptr : &found->second.first;
    }

    ModelMaterial obj_material(const MtlMaterial* mtl, bool has_texcoords)
    {
        ModelMaterial material;
        material.vertex_colors = !model_.mesh.colors.empty();
        if (mtl == nullptr)
            return material;
        material.name = mtl->name;
        if (!mtl->picture.empty() && has_texcoords)
        {
            const fs::path& mtl_file = materials_.at(mtl->name).second;
            const std::string place = fmt::format("{}:{}: map_Kd", mtl_file.string(), mtl->picture_line);
            material.picture = picture_number(FileFolder(mtl_file).find(mtl->picture, place, shape_only));
            material.wrap_u = material.wrap_v = mtl->clamp ? fresco::Wrap::clamp : fresco::Wrap::repeat;
            material.vertex_colors = false;
        }
        else if (!material.vertex_colors)
            material.color = linear_color(mtl->color);
        return material;
    }

    ModelMaterial ply_material(std::uint32_t picture)
    {
        ModelMaterial material;
        if (!named_.names.empty())
        {
            material.name = named_.names[picture].name;
            const auto rgb = static_cast<unsigned>(std::stoul(material.name.substr(1), nullptr, 16));
            material.color = linear_color({(rgb >> 16U) / 255.0, (rgb >> 8U & 255U) / 255.0, (rgb & 255U) / 255.0});
        }
        else if (picture != MeshMaterials::none && !model_.mesh.texcoords.empty())
        {
            const auto& name = named_.files.at(picture);
            material.name = name.name;
            material.picture = picture_number(folder_.find(name.name, place_of(name, "comment TextureFile"), shape_only));
        }
        else
            material.vertex_colors = !model_.mesh.colors.empty();
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

    static void place(fresco::Vec2f& uv, const MtlMaterial& mtl)
    {
        uv = {static_cast<float>(double{uv.x} * mtl.scale.x + mtl.offset.x),
              static_cast<float>(double{uv.y} * mtl.scale.y + mtl.offset.y)};
    }

    const fs::path& file_;
    FileFolder folder_;
    const MeshMaterials& named_;
    FileModel& model_;
    std::map<std::string, std::pair<MtlMaterial, fs::path>> materials_;
};

}  // namespace

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
    if (with_materials)
    {
        MeshMaterials named;
        model.mesh = fresco::read_mesh(file, {}, &model.report, &named);
        MaterialReader reader(file, named, model);
        extension == ".obj" ? reader.read_obj() : reader.read_ply();
    }
    else
    {
        model.mesh = fresco::read_mesh(file, {}, &model.report);
        model.materials.emplace_back().vertex_colors = !model.mesh.colors.empty();
        model.material_of_face.assign(model.mesh.triangles.size(), 0);
    }
    model.split_vertices = extension == ".ply" && !model.mesh.texcoords.empty();
    return model;
}

}  // namespace scan_mesh
