#include "catch.h"

#include <fresco/gltf/compression.h>

using namespace fresco;

TEST_CASE("Where Draco is missing, a primitive without a plain form is refused by the library's name")
{
    tinygltf::Model model;
    model.accessors.resize(1);
    tinygltf::Primitive primitive;
    primitive.attributes["POSITION"] = 0;
    const Value form = Value::Map{{"bufferView", 0}, {"attributes", Value::Map{{"POSITION", 7}}}};
    const auto unpack = [&] { gltf::unpack_draco(model, primitive, {}, form); };
    CHECK_THROWS_WITH(unpack(), Contains("KHR_draco_mesh_compression") && Contains("without Draco") &&
                                    Contains("install libdraco-dev") && Contains("without compression"));
    model.accessors[0].bufferView = 0;
    CHECK_NOTHROW(unpack());
}
