#include <fresco/gltf/compression.h>

#include <fresco/error.h>

/// \file Where the Draco library is missing.

namespace fresco::gltf
{

void unpack_draco(tinygltf::Model& model, tinygltf::Primitive& primitive, std::span<const std::byte>, const Value& form)
{
    for (const auto& [name, id] : form.at("attributes").as_map())
    {
        const auto accessor = primitive.attributes.find(name);
        if (accessor == primitive.attributes.end() || accessor->second >= static_cast<int>(model.accessors.size()) ||
            model.accessors[static_cast<std::size_t>(accessor->second)].bufferView < 0)
            throw Error("it is packed by KHR_draco_mesh_compression, and this fresco was built without Draco, which unpacks it; "
                        "install libdraco-dev and build fresco again, or export the model without compression");
    }
}

}  // namespace fresco::gltf
