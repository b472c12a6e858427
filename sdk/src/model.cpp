#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/model.h>
#include <fresco/npy.h>
#include <fresco/strict_map.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <span>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> wrap_names{"repeat", "mirror", "clamp"};

Value to_value(const ModelMaterial& material)
{
    const auto wrap = [](Wrap w) { return Value(wrap_names.at(static_cast<std::size_t>(w))); };
    const Vec3d color = vec_cast<double>(material.color);
    return Value::Map{{"name", material.name},
                      {"color", Value::List{color.x, color.y, color.z}},
                      {"picture", material.picture},
                      {"wrap", Value::List{wrap(material.wrap_u), wrap(material.wrap_v)}},
                      {"vertex_colors", material.vertex_colors}};
}

const Value& item(const Value& list, std::size_t at, std::size_t expected)
{
    if (list.as_list().size() != expected)
        throw Error(fmt::format("expected a list of {} items", expected));
    return list.as_list()[at];
}

Wrap wrap_from(const Value& name)
{
    const auto found = std::ranges::find(wrap_names, name.as_string());
    if (found == wrap_names.end())
        throw Error("wrap: \"" + name.as_string() + "\"; expected repeat, mirror or clamp");
    return static_cast<Wrap>(found - wrap_names.begin());
}

ModelMaterial material_from(const Value& value)
{
    StrictMap map(value);
    ModelMaterial material;
    material.name = map.take("name").as_string();
    const Value& color = map.take("color");
    const auto light = [&](std::size_t i) { return static_cast<float>(item(color, i, 3).as_double()); };
    material.color = {light(0), light(1), light(2)};
    material.picture = static_cast<int>(map.take("picture").as_int());
    const Value& wrap = map.take("wrap");
    material.wrap_u = wrap_from(item(wrap, 0, 2));
    material.wrap_v = wrap_from(item(wrap, 1, 2));
    material.vertex_colors = map.take("vertex_colors").as_bool();
    map.refuse_others();
    return material;
}

void check_picture(const std::string& name, const fs::path& folder)
{
    if (name.empty() || name == ".." || name.find('/') != std::string::npos)
        throw Error(folder.string() + ": \"" + name + "\" is not a file name");
    if (!is_file(folder / name))
        throw Error((folder / name).string() + ": this picture of the model was not written");
}

bool is_light(float value)
{
    return value >= 0 && value <= 1;
}

}  // namespace

Model::~Model() = default;

void Model::save(const ArtifactFolder& folder) const
{
    for (const std::string& picture : pictures)
        check_picture(picture, folder.path);
    mesh.save(folder);
    const std::array<std::size_t, 1> shape{material_of_face.size()};
    write_file(folder.path / "materials.npy", to_npy(NpyType::uint32, shape, std::as_bytes(std::span(material_of_face))));
    Value::List list;
    for (const ModelMaterial& material : materials)
        list.push_back(to_value(material));
    write_file(
        folder.path / "model.json",
        to_json(Value::Map{{"materials", std::move(list)}, {"pictures", Value::List(pictures.begin(), pictures.end())}}, 1));
}

std::shared_ptr<Model> Model::load(const ArtifactFolder& folder)
{
    auto model = std::make_shared<Model>();
    model->loaded_from = folder.path;
    model->mesh = std::move(*Mesh::load(folder));
    const auto values = read_npy(folder.path / "materials.npy");
    const auto numbers = values.as<std::uint32_t>();
    model->material_of_face.assign(numbers.begin(), numbers.end());
    const fs::path file = folder.path / "model.json";
    const Value root = detail::read_json_file(file);
    try
    {
        for (const Value& material : root.at("materials").as_list())
            model->materials.push_back(material_from(material));
        for (const Value& picture : root.at("pictures").as_list())
            model->pictures.push_back(picture.as_string());
    }
    catch (const Error& error)
    {
        throw Error(file.string() + ": " + error.what());
    }
    for (const std::string& picture : model->pictures)
        check_picture(picture, folder.path);
    check_model(*model, folder.path.string());
    return model;
}

void check_model(const Model& model, std::string_view source)
{
    check_mesh(model.mesh, source);
    const auto fail = [&](const std::string& what) { throw Error(std::string(source) + ": " + what); };
    if (model.material_of_face.size() != model.mesh.triangles.size())
        fail(fmt::format("materials of {} faces; expected {}", model.material_of_face.size(), model.mesh.triangles.size()));
    for (std::size_t face = 0; face < model.material_of_face.size(); ++face)
        if (model.material_of_face[face] >= model.materials.size())
            fail(fmt::format("face {} names material {} of {}", face, model.material_of_face[face], model.materials.size()));
    for (const ModelMaterial& material : model.materials)
    {
        const std::string name = "material \"" + material.name + "\"";
        if (!is_light(material.color.x) || !is_light(material.color.y) || !is_light(material.color.z))
            fail(name + " has a color outside of 0 to 1");
        if (material.picture < ModelMaterial::no_picture || material.picture >= static_cast<int>(model.pictures.size()))
            fail(fmt::format("{} names picture {} of {}", name, material.picture, model.pictures.size()));
        if (material.picture != ModelMaterial::no_picture && model.mesh.texcoords.empty())
            fail(name + " has a picture, but the mesh has no texcoords");
        if (material.vertex_colors && model.mesh.colors.empty())
            fail(name + " has vertex colors, but the mesh has none");
    }
}

}  // namespace fresco
