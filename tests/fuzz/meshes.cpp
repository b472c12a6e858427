#include "parsers.h"

#include <fresco/mesh.h>

namespace fresco::fuzz
{
namespace
{

/// As PLY it reads back as it is.
void check(const Mesh& mesh)
{
    check_mesh(mesh, "the mesh");
    const auto bytes = to_ply(mesh);
    const Mesh again = parse_ply(bytes, "its own PLY");
    require(again.positions.size() == mesh.positions.size() && again.triangles == mesh.triangles,
            "written and read, the same mesh");
}

void read(Bytes bytes, const auto& parse)
{
    MeshReadReport report;
    check(parse(bytes, source, MeshLimits{}, &report));
    MeshMaterials materials;
    const Mesh mesh = parse(bytes, source, MeshLimits{}, &report, &materials);
    require(materials.of_face.empty() || materials.of_face.size() == mesh.triangles.size(), "a material per face");
}

void read_ply(Bytes bytes)
{
    read(bytes, [](auto&&... arguments) { return parse_ply(std::forward<decltype(arguments)>(arguments)...); });
    PlyIntegers integers{.property = "chart", .of_vertex = {}, .of_face = {}};
    Mesh mesh;
    if (refused([&] { mesh = parse_ply(bytes, source, MeshLimits{}, nullptr, nullptr, &integers); }))
        return;  // Most files have no such property.
    require(integers.of_face.empty() || integers.of_face.size() == mesh.triangles.size(), "an integer per face");
    require(integers.of_vertex.empty() || integers.of_vertex.size() == mesh.positions.size(), "an integer per vertex");
}

void read_obj(Bytes bytes)
{
    read(bytes, [](auto&&... arguments) { return parse_obj(std::forward<decltype(arguments)>(arguments)...); });
}

const Registered registered{{"ply", "sdk/src/ply(_header)?\\.cpp|sdk/src/mesh_text\\.h", read_ply},
                            {"obj", "sdk/src/obj\\.cpp", read_obj}};

}  // namespace
}  // namespace fresco::fuzz
