#include <fresco/mesh.h>
#include <fresco/mesh_io.h>

#include "mesh_builder.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <span>
#include <string>

namespace fresco
{
namespace
{

// Within these, algorithms may square areas in single precision: those of the largest mesh stay a billion times below the largest
// number, those of a millionth of the smallest, of a face then, a billion times above the smallest. Maps reach to 1e7 m (UTM).
constexpr float farthest_vertex_m = 1e7F;
constexpr double smallest_m2 = 1e-8;

bool is_finite(Vec3f p)
{
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool is_near(Vec3f p)
{
    return std::abs(p.x) <= farthest_vertex_m && std::abs(p.y) <= farthest_m && std::abs(p.z) <= farthest_m;
}

/// Twice the area times the unit normal, in double: scans have slivers whose float cross product is noise.
Vec3d area_normal(const Mesh& mesh, const Triangle& triangle)
{
    const auto a = vec_cast<double>(mesh.positions[triangle[0]]);
    const auto b = vec_cast<double>(mesh.positions[triangle[1]]);
    const auto c = vec_cast<double>(mesh.positions[triangle[2]]);
    return cross(b - a, c - a);
}

/// By its extension; throws Error unless it is .ply or .obj.
bool is_ply_file(const std::filesystem::path& file)
{
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    if (extension != ".ply" && extension != ".obj")
        throw Error(file.string() + ": unknown extension; a mesh is read from a .ply or .obj file");
    return extension == ".ply";
}

}  // namespace

Mesh::~Mesh() = default;

void Mesh::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / file_name, to_ply(*this));
}

std::vector<ExchangeForm> Mesh::exchange_forms()
{
    return {{.files = {"mesh.ply"}, .is_folder = false, .taken_in_place = false, .made_in_place = false}};
}

std::shared_ptr<Mesh> Mesh::load(const ArtifactFolder& folder)
{
    const auto file = folder.path / file_name;
    return std::make_shared<Mesh>(
        detail::parse_ply_faces(read_file(file), file.string(), MeshLimits{}, nullptr, detail::DegenerateFaces::keep));
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
        if (!is_finite(mesh.positions[i]))
            fail(fmt::format("the position of vertex {} is not finite", i));
        else if (!is_near(mesh.positions[i]))
            fail(fmt::format(
                "vertex {} is more than 1e7 m from the origin, at ({:g}, {:g}, {:g}): the mesh is damaged, or of another "
                "unit",
                i, mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z));
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
    std::transform(sums.begin(), sums.end(), normals.begin(), [](Vec3d sum) { return vec_cast<float>(normalized(sum)); });
    return normals;
}

Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits, MeshReadReport* report)
{
    const bool is_ply = is_ply_file(file);
    const auto bytes = read_file(file);
    return is_ply ? parse_ply(bytes, file.string(), limits, report) : parse_obj(bytes, file.string(), limits, report);
}

Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits, MeshReadReport* report, MeshMaterials& materials)
{
    const bool is_ply = is_ply_file(file);
    const auto bytes = read_file(file);
    return is_ply ? parse_ply(bytes, file.string(), limits, report, materials)
                  : parse_obj(bytes, file.string(), limits, report, materials);
}

}  // namespace fresco
