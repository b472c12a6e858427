#include "artifact_files.h"
#include "mesh_text.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/run_context.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <system_error>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

// Within these, algorithms may square areas in single precision: those of the largest mesh stay a billion times below the largest
// number, those of a millionth of the smallest, of a face then, a billion times above the smallest. Maps reach to 1e7 m (UTM).
constexpr double farthest_vertex_m = 1e7;
constexpr double smallest_m2 = 1e-8;
// From here on, floats are more than 0.1 mm apart.
constexpr double coarse_m = 1024;
constexpr double offset_step_m = 100;
constexpr double written_steps_per_m = 1e5;

/// Whether no coordinate is larger than `most`, or NaN.
bool are_within(Vec3d p, double most)
{
    return std::abs(p.x) <= most && std::abs(p.y) <= most && std::abs(p.z) <= most;
}

/// Twice the area times the unit normal, in double: scans have slivers whose float cross product is noise.
Vec3d area_normal(const Mesh& mesh, const Triangle& triangle)
{
    const auto a = vec_cast<double>(mesh.positions[triangle[0]]);
    const auto b = vec_cast<double>(mesh.positions[triangle[1]]);
    const auto c = vec_cast<double>(mesh.positions[triangle[2]]);
    return cross(b - a, c - a);
}

}  // namespace

void Mesh::save(const ArtifactFolder& folder) const
{
    if (std::error_code error; !saved_in.empty())
    {
        fs::create_hard_link(saved_in / file_name, folder.path / file_name, error);
        if (!error)
            return;
    }
    // Not every file system has links.
    write_file(folder.path / file_name, to_ply(*this));
}

std::vector<ExchangeForm> Mesh::exchange_forms()
{
    return {{.files = {"mesh.ply"}, .is_folder = false, .taken_in_place = false, .made_in_place = false}};
}

std::shared_ptr<Mesh> Mesh::load(const ArtifactFolder& folder)
{
    const auto file = folder.path / file_name;
    return std::make_shared<Mesh>(detail::parse_ply_faces(read_file(file), file.string(), MeshLimits{}, nullptr, true));
}

void check_mesh(const Mesh& mesh, std::string_view source)
{
    const auto fail = [&](const std::string& what) { throw Error(std::string(source) + ": " + what); };
    const auto sizes = [&](const char* name, std::size_t size, std::size_t expected)
    {
        if (size != 0 && size != expected)
            fail(fmt::format("{} {}; expected {} or none", size, name, expected));
    };
    if (mesh.triangles.empty())
        fail("the mesh has no faces");
    sizes("colors", mesh.colors.size(), mesh.positions.size());
    sizes("texcoords", mesh.texcoords.size(), mesh.triangles.size() * 3);
    sizes("charts", mesh.charts.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        const Vec3d p = vec_cast<double>(mesh.positions[i]) + mesh.offset_m;
        if (!are_within(p, std::numeric_limits<double>::max()))
            fail(fmt::format("the position of vertex {} is not finite", i));
        if (!are_within(p, farthest_vertex_m))
            fail(fmt::format(
                "vertex {} is more than 1e7 m from the origin, at ({:g}, {:g}, {:g}): the mesh is damaged, or of another "
                "unit",
                i, p.x, p.y, p.z));
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const std::uint32_t index : mesh.triangles[i])
            if (index >= mesh.positions.size())
                fail(fmt::format("face {} names vertex {} of {}", i, index, mesh.positions.size()));
    double area_m2 = 0;
    for (const Triangle& triangle : mesh.triangles)
        area_m2 += length(area_normal(mesh, triangle)) / 2;
    if (!(area_m2 >= smallest_m2))
        fail(fmt::format(
            "the faces have an area of {:.3g} m² in all; at least 1e-8 m², 0.1 mm x 0.1 mm, are accepted: the mesh is "
            "damaged, or of another unit",
            area_m2));
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i)
        if (!std::isfinite(mesh.texcoords[i].x) || !std::isfinite(mesh.texcoords[i].y))
            fail(fmt::format("the texcoord of corner {} of face {} is not finite", i % 3, i / 3));
}

Vec3d offset_for(std::span<const Vec3d> points)
{
    Vec3d offset;
    std::vector<double> along(points.size());
    const auto ranked = [&](std::size_t rank)
    {
        std::ranges::nth_element(along, along.begin() + static_cast<std::ptrdiff_t>(rank));
        return along[rank];
    };
    const std::size_t strays = points.size() / 8;
    // Cameras in millimeters are at one height, so the widest axis decides for all.
    double spread = 0;
    Vec3d middle;
    for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z})
    {
        std::ranges::transform(points, along.begin(), axis);
        middle.*axis = along.empty() ? 0 : ranked(along.size() / 2);
        spread = along.empty() ? 0 : std::max(spread, ranked(along.size() - 1 - strays) - ranked(strays));
    }
    for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z})
        if (std::abs(middle.*axis) >= coarse_m && std::abs(middle.*axis) > spread)
            offset.*axis = std::round(middle.*axis / offset_step_m) * offset_step_m;
    return offset;
}

void place(Mesh& mesh, std::span<const Vec3d> positions, Vec3d offset_m)
{
    mesh.offset_m = offset_m;
    mesh.positions.resize(positions.size());
    std::ranges::transform(positions, mesh.positions.begin(), [&](Vec3d p) { return vec_cast<float>(p - offset_m); });
}

std::vector<Vec3d> world_positions(const Mesh& mesh)
{
    std::vector<Vec3d> positions(mesh.positions.size());
    const auto rounded = [](double m) { return std::round(m * written_steps_per_m) / written_steps_per_m; };
    std::ranges::transform(mesh.positions, positions.begin(),
                           [&](Vec3f stored)
                           {
                               const Vec3d p = vec_cast<double>(stored) + mesh.offset_m;
                               return mesh.offset_m == Vec3d{} ? p : Vec3d{rounded(p.x), rounded(p.y), rounded(p.z)};
                           });
    return positions;
}

void tell_offset(Vec3d offset_m, RunContext& run)
{
    if (offset_m == Vec3d{})
        return;
    run.report("offset_m", Value::List{offset_m.x, offset_m.y, offset_m.z});
    run.message(fmt::format("far from 0, where floats are more than 0.1 mm apart: ({}, {}, {}) m are taken off all coordinates; "
                            "export.mesh puts them back with coordinates: original",
                            offset_m.x, offset_m.y, offset_m.z));
}

std::vector<Vec3f> face_normals(const Mesh& mesh)
{
    std::vector<Vec3f> normals;
    normals.reserve(mesh.triangles.size());
    for (const Triangle& triangle : mesh.triangles)
        normals.push_back(vec_cast<float>(normalized(area_normal(mesh, triangle))));
    return normals;
}

std::string atlas_id(const Mesh& mesh)
{
    return content_hash(content_hash(std::as_bytes(std::span(mesh.triangles))) +
                        content_hash(std::as_bytes(std::span(mesh.texcoords))));
}

void check_atlas(const std::string& id, const Mesh& mesh, std::string_view source)
{
    if (!id.empty() && id != atlas_id(mesh))
        throw Error(std::string(source) + " was made for another atlas than the mesh on port 'mesh': wire the atlas.* stage that "
                                          "its uv maps were made with");
}

std::vector<Vec3f> vertex_normals(const Mesh& mesh)
{
    std::vector<Vec3d> sums(mesh.positions.size());
    for (const Triangle& triangle : mesh.triangles)
    {
        const Vec3d normal = area_normal(mesh, triangle);
        for (const std::uint32_t index : triangle)
            sums[index] += normal;
    }
    std::vector<Vec3f> normals(sums.size());
    std::ranges::transform(sums, normals.begin(), [](Vec3d sum) { return vec_cast<float>(normalized(sum)); });
    return normals;
}

Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits, MeshReadReport* report, MeshMaterials* materials)
{
    const std::string extension = lower_extension(file);
    if (extension != ".ply" && extension != ".obj")
        throw Error(file.string() + ": unknown extension; a mesh is read from a .ply or .obj file");
    const auto bytes = read_file(file);
    return extension == ".ply" ? parse_ply(bytes, file.string(), limits, report, materials)
                               : parse_obj(bytes, file.string(), limits, report, materials);
}

namespace
{

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

Wrap wrap_from(const JsonPlace& name)
{
    const auto found = std::ranges::find(wrap_names, name.text());
    if (found == wrap_names.end())
        name.fail("\"" + name.text() + "\"; expected repeat, mirror or clamp");
    return static_cast<Wrap>(found - wrap_names.begin());
}

ModelMaterial material_from(const JsonPlace& place)
{
    place.has_only({"name", "color", "picture", "wrap", "vertex_colors"});
    ModelMaterial material;
    material.name = place["name"].text();
    const auto color = place["color"].numbers(3);
    material.color = {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
    material.picture = static_cast<int>(place["picture"].integer(ModelMaterial::no_picture, std::numeric_limits<int>::max()));
    const auto wrap = place["wrap"].list(2);
    material.wrap_u = wrap_from(wrap[0]);
    material.wrap_v = wrap_from(wrap[1]);
    material.vertex_colors = place["vertex_colors"].flag();
    return material;
}

void check_picture(const std::string& name, const fs::path& folder)
{
    if (name.empty() || name == ".." || name.find('/') != std::string::npos)
        throw Error(folder.string() + ": \"" + name + "\" is not a file name");
    if (!is_file(folder / name))
        throw Error((folder / name).string() + ": this picture of the model was not written");
}

}  // namespace

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
    const detail::JsonFile file(folder.path / "model.json");
    for (const JsonPlace& material : file["materials"].list())
        model->materials.push_back(material_from(material));
    model->pictures = file["pictures"].texts();
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
    const auto is_light = [](float value) { return value >= 0 && value <= 1; };
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
