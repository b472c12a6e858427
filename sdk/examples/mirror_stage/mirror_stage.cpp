#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <utility>

namespace
{

/// Negating one axis turns every face inside out, so the corners are swapped back.
fresco::Mesh mirrored(fresco::Mesh mesh, char axis)
{
    for (fresco::Vec3f& p : mesh.positions)
    {
        float& coordinate = axis == 'x' ? p.x : axis == 'y' ? p.y : p.z;
        coordinate = -coordinate;
    }
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        std::swap(mesh.triangles[face][1], mesh.triangles[face][2]);
        if (!mesh.texcoords.empty())
            std::swap(mesh.texcoords[3 * face + 1], mesh.texcoords[3 * face + 2]);
    }
    return mesh;
}

class Mirror final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh"};
    fresco::Output<fresco::Mesh> mirrored_mesh{this, "mirrored", "The mesh seen in a mirror"};
    fresco::Option<std::string> axis{this, "axis", "x", fresco::one_of({"x", "y", "z"}), "Axis that changes its sign"};

    void run(fresco::RunContext& run) override
    {
        mirrored_mesh = mirrored(*mesh, axis->front());
        run.report("faces", mesh->triangles.size());
    }
};

}  // namespace

FRESCO_STAGE("example.mirror", Mirror, "Mirrors a mesh")
