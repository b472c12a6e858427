#pragma once

#include <fresco/stage.h>
#include <fresco/texture.h>

namespace fresco::texturing
{

/// What an export writes, of which one is wired: a mesh with its picture, or one without. Declared in the stage as
/// `ExportedMesh mesh{this};`.
class ExportedMesh
{
  public:
    explicit ExportedMesh(Configurable* owner);

    /// Throws Error unless one of the ports is wired, to what can be exported (check_textured_mesh, check_mesh).
    void check() const;

    bool has_picture() const { return textured_.has_value(); }
    const TexturedMesh& textured() const { return *textured_; }
    const Mesh& mesh() const { return has_picture() ? textured_->mesh : *mesh_; }

  private:
    Input<TexturedMesh> textured_;
    Input<Mesh> mesh_;
};

}  // namespace fresco::texturing
