#include "file_model.h"

#include <fresco/error.h>

namespace scan_mesh
{

FileModel read_gltf_model(const std::filesystem::path& file, bool)
{
    throw fresco::Error(file.string() + ": this build of scan.mesh reads no glTF: build it with tinygltf (Debian: "
                                        "libtinygltf-dev), or save the model as OBJ");
}

}  // namespace scan_mesh
