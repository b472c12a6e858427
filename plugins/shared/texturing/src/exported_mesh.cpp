#include <fresco/texturing/exported_mesh.h>

#include <fresco/error.h>
#include <fresco/texturing/exported_file.h>

namespace fresco::texturing
{

ExportedMesh::ExportedMesh(Configurable* owner)
    : textured_(owner, "textured_mesh", optional, "The mesh with its picture, as texture.bake makes it"),
      mesh_(owner, "mesh", optional, "Alternatively, a mesh or atlas without a picture, with its vertex colors")
{
}

void ExportedMesh::check() const
{
    if (textured_.has_value() == mesh_.has_value())
        throw Error(textured_.has_value()
                        ? "both 'textured_mesh' and 'mesh' are wired: wire one of them"
                        : "wire 'textured_mesh' (a texture.bake stage), or 'mesh' for a mesh without a picture");
    if (has_picture())
        check_textured_mesh(*textured_, "the mesh on port 'textured_mesh'");
    else
        check_mesh(*mesh_, "the mesh on port 'mesh'");
}

}  // namespace fresco::texturing
