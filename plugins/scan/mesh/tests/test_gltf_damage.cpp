#include "catch.h"
#include "file_model.h"

#include "model_samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>

using namespace fresco;
using namespace model_samples;

namespace
{

/// Reads a model; what comes back can be used.
void read_usable(const std::filesystem::path& file)
{
    auto read = scan_mesh::read_file_model(file, true);
    Model model;
    model.mesh = std::move(read.mesh);
    model.materials = std::move(read.materials);
    model.material_of_face = std::move(read.material_of_face);
    for (const auto& picture : read.pictures)
        model.pictures.push_back(picture.name);
    check_model(model, "the model");
}

/// The message about a triangle's GLB; empty where it is read.
std::string error_of_file(const std::vector<std::byte>& glb)
{
    const testing::TemporaryFolder folder;
    write_file(folder.path() / "a.glb", glb);
    return testing::error_of([&] { read_usable(folder.path() / "a.glb"); });
}

/// The message after a change to the triangle's parts.
template <class F>
std::string error_after(const F& change)
{
    TriangleSample triangle;
    change(triangle);
    return error_of_file(triangle.finished().glb());
}

}  // namespace

TEST_CASE("glTF: what is not supported is refused by name, with a way out", "[scan.mesh]")
{
    const auto needing = [](const char* extension)
    { return error_after([&](TriangleSample& t) { t.sample.rest.set("extensionsRequired", Value::List{extension}); }); };
    CHECK(needing("KHR_materials_unlit").empty());
    CHECK(needing("KHR_materials_variants").empty());
    CHECK_THAT(needing("KHR_texture_basisu"), Contains("KHR_texture_basisu") && Contains("PNG or JPEG pictures"));
    CHECK_THAT(needing("ACME_soup"), Contains("ACME_soup, which is not supported; export the model without it"));
}

TEST_CASE("glTF: sparse accessors that are wrong are refused before anything is allocated", "[scan.mesh]")
{
    /// One row of the triangle replaced, after a change to the accessor, its part `sparse` and the indices.
    const auto error_of = [](const std::vector<std::uint32_t>& indices, const auto& change)
    {
        return error_after(
            [&](TriangleSample& t)
            {
                Value sparse = Value::Map{
                    {"count", indices.size()},
                    {"indices", Value::Map{{"bufferView", t.sample.add_view(indices)}, {"componentType", 5125}}},
                    {"values", Value::Map{{"bufferView", t.sample.add_view(std::vector<float>(3 * indices.size(), 2))}}}};
                change(t.sample.accessors[0], sparse);
                t.sample.accessors[0].set("sparse", sparse);
            });
    };
    const auto nothing = [](Value&, Value&) {};
    CHECK(error_of({1}, nothing).empty());
    const std::string place = "meshes[0]: primitives[0]: accessors[0]: sparse: ";
    CHECK_THAT(error_of({1, 1}, nothing), Contains(place + "index 1 is 1; expected increasing ones below 3"));
    CHECK_THAT(error_of({3}, nothing), Contains(place + "index 0 is 3"));
    CHECK_THAT(error_of({1}, [](Value&, Value& sparse) { sparse.find("indices")->set("componentType", 5126); }),
               Contains(place + "expected unsigned integers as indices"));
    CHECK_THAT(error_of({1}, [](Value&, Value& sparse) { sparse.find("indices")->set("byteOffset", 1); }),
               Contains(place + "indices: 1 rows of 4 bytes at byte 1 do not fit"));
    CHECK_THAT(error_of({1}, [](Value&, Value& sparse) { sparse.find("values")->set("bufferView", 7); }),
               Contains(place + "values: it has no valid bufferView"));
    CHECK_THAT(error_of({1}, [](Value&, Value& sparse) { sparse.set("count", 2); }), Contains("indices: 2 rows of 4 bytes"));
    CHECK_THAT(error_of({1}, [](Value&, Value& sparse) { sparse.find("values")->set("byteOffset", std::int64_t{1} << 32U); }),
               Contains("accessors[0].sparse.values.byteOffset: expected a whole number from 0 to 2147483647, not 4294967296"));
    CHECK_THAT(error_of({1},
                        [](Value& accessor, Value&)
                        {
                            std::erase_if(accessor.as_map(), [](const auto& each) { return each.first == "bufferView"; });
                            accessor.set("count", 4'000'000'000'000);
                        }),
               Contains(place + "4000000000000 rows in a file of 52 bytes"));
}

TEST_CASE("glTF: copies of a mesh that are wrong or too many are refused with their node", "[scan.mesh]")
{
    const auto error_of = [](const auto& attributes)
    {
        return error_after(
            [&](TriangleSample& t)
            {
                const Value instancing = Value::Map{{"attributes", attributes(t)}};
                t.sample.rest.set(
                    "nodes",
                    Value::List{Value::Map{{"mesh", 0}, {"extensions", Value::Map{{"EXT_mesh_gpu_instancing", instancing}}}}});
            });
    };
    const std::string place = "nodes[0]: EXT_mesh_gpu_instancing: ";
    CHECK_THAT(error_of([](TriangleSample&) { return Value::Map{{"TRANSLATION", 3}}; }), Contains(place + "accessor 3 of 1"));
    CHECK_THAT(error_of([](TriangleSample&) { return Value::Map{{"ROTATION", 0}}; }), Contains("expected 4 to 4 components"));
    CHECK_THAT(error_of([](TriangleSample&) { return Value::Map{{"SCALE", -1}}; }), Contains(".SCALE: expected a whole number"));
    const auto more = [](TriangleSample& t, std::size_t count)
    { return t.sample.add_accessor(std::vector<float>(3 * count, 1), "VEC3", 5126, count); };
    CHECK_THAT(error_of(
                   [&](TriangleSample& t) {
                       return Value::Map{{"TRANSLATION", 0}, {"SCALE", more(t, 2)}};
                   }),
               Contains(place + "SCALE of 2 copies; expected 3"));
    CHECK_THAT(error_of(
                   [&](TriangleSample& t)
                   {
                       const int turns = t.sample.add_accessor(std::vector<std::int8_t>(12, 0), "VEC4", 5120, 3, true);
                       return Value::Map{{"ROTATION", turns}};
                   }),
               Contains(place + "rotation: expected a quaternion"));
    CHECK_THAT(error_of(
                   [&](TriangleSample& t)
                   {
                       t.attributes.set("POSITION", more(t, 3000));
                       return Value::Map{{"TRANSLATION", more(t, 70'000)}};
                   }),
               Contains("meshes[0]: primitives[0]: more than 200000000 vertices"));
}

TEST_CASE("glTF: JSON that is nested deep never reaches the recursive parser", "[scan.mesh]")
{
    const GltfSample sample = TriangleSample().finished();
    const std::string text = to_json(sample.document());
    for (const int depth : {60, 1'000'000})
    {
        std::string nested = text;
        nested.insert(1, "\"extras\":" + std::string(static_cast<std::size_t>(depth), '[') +
                             std::string(static_cast<std::size_t>(depth), ']') + ",");
        const std::string error = error_of_file(sample.assembled(nested));
        if (depth < 64)
            CHECK(error.empty());
        else
            CHECK_THAT(error, Contains("nested more than 64 levels deep"));
    }
}

TEST_CASE("glTF: ranges and indices that are wrong are refused with their entry", "[scan.mesh]")
{
    CHECK(error_after([](TriangleSample&) {}).empty());
    const auto refused = [](const auto& change, const std::string& reason)
    { CHECK_THAT(error_after(change), Contains("a.glb: ") && Contains(reason)); };
    const auto accessor = [&](const char* key, const Value& value, const std::string& reason)
    { refused([&](TriangleSample& t) { t.sample.accessors[0].set(key, value); }, reason); };
    const auto view = [&](const char* key, const Value& value, const std::string& reason)
    { refused([&](TriangleSample& t) { t.sample.views[0].set(key, value); }, reason); };
    const auto list = [&](const char* key, const Value& entry, const std::string& reason)
    { refused([&](TriangleSample& t) { t.sample.rest.set(key, Value::List{entry}); }, reason); };
    const auto indices = [&](const std::vector<std::uint32_t>& numbers, const std::string& reason)
    {
        refused([&](TriangleSample& t)
                { t.primitive.set("indices", t.sample.add_accessor(numbers, "SCALAR", 5125, numbers.size())); },
                reason);
    };
    accessor("count", 4, "accessors[0]: 4 rows of 12 bytes");
    accessor("count", 4'000'000'000'000'000'000, "accessors[0]: 4000000000000000000 rows");
    accessor("count", 0, "accessors[0]: 0 rows");
    accessor("type", "VEC2", "accessors[0]: expected 3 to 3 components");
    accessor("componentType", 5124, "componentType 5124");
    view("buffer", 1, "bufferViews[0]: buffer 1 of 1");
    view("byteLength", 37, "bufferViews[0]: 37 bytes at 0 do not fit");
    refused([](TriangleSample& t) { t.attributes = Value::Map{{"NORMAL", 0}}; }, "accessor -1 of 1");
    indices({0, 1, 3}, "accessors[1]: index 2 names vertex 3 of 3");
    indices({0, 1}, "2 corners; expected a multiple of 3");
    list("nodes", Value::Map{{"children", Value::List{0}}}, "nodes[0]: the node appears twice in the tree");
    list("nodes", Value::Map{{"mesh", 1}}, "nodes[0]: mesh 1 of 1");
    refused([](TriangleSample& t) { t.sample.rest.set("scene", 2); }, "scene 2 of 1");
    list("nodes", Value::Map{{"mesh", 0}, {"scale", Value::List{1, 2}}}, "nodes[0]: scale: expected 3 finite numbers");
    list("nodes", Value::Map{{"mesh", 0}, {"rotation", Value::List{0, 0, 0, 0}}}, "nodes[0]: rotation: expected a quaternion");
    list("nodes", Value::Map{{"mesh", 0}, {"translation", Value::List{1e300, 0, 0}}}, "vertex 0 is not finite");
    list("buffers", Value::Map{{"byteLength", 99}}, "buffers[0]: byteLength is 99, but there are 36 bytes");
    // tinygltf would read these as 0 or as missing.
    for (const Value& value : {Value(-4), Value(1.5), Value(1e300), Value("4"), Value(Value::List{4})})
        accessor("byteOffset", value, "accessors[0].byteOffset: expected a whole number from 0 to ");
    refused([](TriangleSample& t) { t.attributes.set("POSITION", std::int64_t{1} << 32U); },
            "meshes[0].primitives[0].attributes.POSITION: expected a whole number from 0 to 2147483647, not 4294967296");
    const GltfSample sample = TriangleSample().finished();
    std::string version = to_json(sample.document());
    version.replace(version.find("2.0"), 3, "1.0");
    CHECK_THAT(error_of_file(sample.assembled(version)), Contains("asset.version is 1.0; expected 2.0"));
    // The version, the lengths of the file and of its chunks, and the kinds of the chunks.
    const std::size_t binary_at = sample.glb().size() - sample.binary.size() - 8;
    const std::string binary = "byte " + std::to_string(binary_at) + ": expected the BIN chunk, inside the file";
    for (const auto& [at, reason] : std::vector<std::pair<std::size_t, std::string>>{{4, "GLB version"},
                                                                                     {11, "byte 8: the header says"},
                                                                                     {15, "byte 12: expected the JSON chunk"},
                                                                                     {16, "byte 12: expected the JSON chunk"},
                                                                                     {binary_at + 3, binary},
                                                                                     {binary_at + 4, binary}})
    {
        auto glb = sample.glb();
        glb[at] ^= std::byte{0x7F};
        CHECK_THAT(error_of_file(glb), Contains("a.glb: ") && Contains(reason));
    }
}
