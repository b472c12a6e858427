#include "bumpy_model.h"
#include "catch.h"
#include "file_model.h"

#include "model_samples.h"

#include <fresco/testing.h>

#include <fmt/format.h>

using namespace fresco;
using namespace model_samples;
using scan_mesh::FileModel;

namespace
{

FileModel read_text(const std::string& json, const testing::TemporaryFolder& folder)
{
    write_file(folder.path() / "a.gltf", json);
    return scan_mesh::read_file_model(folder.path() / "a.gltf", true);
}

/// An entry of the document beside its meshes, accessors and views.
void set(GltfSample& sample, const char* key, const std::string& json)
{
    sample.rest.set(key, parse_json(json));
}

/// A triangle with texcoords (0.25, 0), (1, 0), (0, 1), in glTF's way, and a picture of one pixel.
TriangleSample textured_triangle()
{
    TriangleSample triangle;
    triangle.attributes.set("TEXCOORD_0",
                            triangle.sample.add_accessor(std::vector<float>{0.25F, 0, 1, 0, 0, 1}, "VEC2", 5126, 3));
    triangle.primitive.set("material", 0);
    set(triangle.sample, "textures", R"([{"source": 0, "sampler": 0}])");
    set(triangle.sample, "samplers", R"([{"wrapS": 33648, "wrapT": 33071}])");
    const int view = triangle.sample.add_view(stored_png::encode(Raster8(1, 1, 3, 9)));
    set(triangle.sample, "images", R"([{"mimeType": "image/png", "bufferView": )" + std::to_string(view) + "}]");
    return triangle;
}

/// Its material, `texture` with more entries.
void set_material(GltfSample& sample, const std::string& more_of_texture = "")
{
    set(sample, "materials",
        R"([{"name": "paper", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 0.25, 1],
        "baseColorTexture": {"index": 0)" +
            more_of_texture + "}}}]");
}

}  // namespace

TEST_CASE("nodes place their meshes; a mirrored one keeps its outside", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle;
    // A quarter turn about z, then twice as large, then moved; the child stands 1 along x.
    set(triangle.sample, "nodes", R"([
        {"children": [1], "translation": [10, 20, 30], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476], "scale": [2, 2, 2]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]}, {"mesh": 0, "scale": [-1, 1, 1]}, {"mesh": 0}])");
    set(triangle.sample, "scenes", R"([{"nodes": [0, 2]}])");
    const FileModel model = read_sample(triangle.finished(), folder);
    REQUIRE(model.mesh.triangles.size() == 2);
    const auto near = [](Vec3f a, Vec3f b) { return length(a - b) < 1e-5F; };
    CHECK(near(model.mesh.positions[0], {10, 22, 30}));
    CHECK(near(model.mesh.positions[1], {10, 24, 30}));
    CHECK(near(model.mesh.positions[2], {8, 22, 30}));
    CHECK(face_normals(model.mesh)[0].z == Approx(1));
    CHECK(near(model.mesh.positions[4], {-1, 0, 0}));
    CHECK(face_normals(model.mesh)[1].z == Approx(1));
    // Without scenes: every node that is nobody's child.
    set(triangle.sample, "scenes", "[]");
    CHECK(read_sample(triangle.finished(), folder).mesh.triangles.size() == 3);
}

TEST_CASE("objects are the nodes with meshes, by their paths", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle;
    set(triangle.sample, "scenes", R"([{"nodes": [0]}])");
    const auto objects = [&](const std::string& nodes)
    {
        set(triangle.sample, "nodes", nodes);
        const FileModel model = read_sample(triangle.finished(), folder);
        std::vector<std::string> names;
        for (const std::uint32_t object : model.object_of_face)
            names.push_back(object < model.objects.size() ? model.objects[object] : "");
        return names;
    };
    using Names = std::vector<std::string>;
    CHECK(objects(R"([{"name": "root", "children": [1, 3, 5]},
                      {"name": "chair", "children": [2]}, {"name": "leg", "mesh": 0},
                      {"name": "table", "mesh": 0, "children": [4]}, {"name": "leg", "mesh": 0},
                      {"children": [6]}, {"name": "lamp", "children": [7]}, {"name": "lamp", "mesh": 0}])") ==
          Names{"root/chair/leg", "root/table", "root/table/leg", "root/lamp"});
    CHECK(objects(R"([{"name": "root", "children": [1]}, {"name": "chair", "mesh": 0}])") == Names{"root/chair"});
    CHECK(objects(R"([{"mesh": 0}])") == Names{""});
    // A name that a hostile file repeats along a chain of nodes.
    const std::string name(200, 'x');
    std::string chain = "[";
    for (int node = 0; node < 40; ++node)
        chain += fmt::format(R"({{"name": "{}{}", "mesh": 0, "children": [{}]}},)", name, node, node + 1);
    for (const std::string& path : objects(chain + R"({"name": "end", "mesh": 0}])"))
        CHECK(path.size() < 600);
}

TEST_CASE("a node's mesh is copied as EXT_mesh_gpu_instancing says, within the node", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle;
    GltfSample& sample = triangle.sample;
    const int at = sample.add_accessor(std::vector<float>{1, 0, 0, 0, 5, 0}, "VEC3", 5126, 2);
    const int size = sample.add_accessor(std::vector<float>{2, 2, 2, -1, 1, 1}, "VEC3", 5126, 2);
    // The second copy is turned by a quarter about z.
    const int turn = sample.add_accessor(std::vector<std::int8_t>{0, 0, 0, 127, 0, 0, 90, 90}, "VEC4", 5120, 2, true);
    const auto read = [&](const Value& attributes)
    {
        const Value extensions = Value::Map{{"EXT_mesh_gpu_instancing", Value::Map{{"attributes", attributes}}}};
        sample.rest.set("nodes",
                        Value::List{Value::Map{{"mesh", 0}, {"translation", Value::List{0, 0, 10}}, {"extensions", extensions}}});
        sample.rest.set("extensionsRequired", Value::List{"EXT_mesh_gpu_instancing"});
        return read_sample(triangle.finished(), folder).mesh;
    };
    const Mesh mesh = read(Value::Map{{"TRANSLATION", at}, {"ROTATION", turn}, {"SCALE", size}, {"_ID", 0}});
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 5, 4}});
    const std::vector<Vec3f> expected{{1, 0, 10}, {3, 0, 10}, {1, 2, 10}, {0, 5, 10}, {0, 4, 10}, {-1, 5, 10}};
    for (std::size_t v = 0; v < expected.size(); ++v)
        CHECK(length(mesh.positions[v] - expected[v]) < 1e-5F);
    CHECK(face_normals(mesh)[1].z == Approx(1));
    CHECK(read(Value::Map{{"TRANSLATION", at}}).positions[4] == Vec3f{1, 5, 10});
    CHECK(read(Value::Map{{"_ID", 0}}).triangles.size() == 1);
}

TEST_CASE("sparse accessors replace rows, of zeros where they have no others", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle;
    GltfSample& sample = triangle.sample;
    const int indices = sample.add_view(std::vector<std::uint16_t>{0, 2});
    const int values = sample.add_view(std::vector<float>{9, 9, 9, 5, 6, 7, 0, 8, 0});
    sample.accessors[0].set("sparse", Value::Map{{"count", 2},
                                                 {"indices", Value::Map{{"bufferView", indices}, {"componentType", 5123}}},
                                                 {"values", Value::Map{{"bufferView", values}, {"byteOffset", 12}}}});
    CHECK(read_sample(triangle.finished(), folder).mesh.positions == std::vector<Vec3f>{{5, 6, 7}, {1, 0, 0}, {0, 8, 0}});
    std::erase_if(sample.accessors[0].as_map(), [](const auto& each) { return each.first == "bufferView"; });
    CHECK(read_sample(triangle.finished(), folder).mesh.positions == std::vector<Vec3f>{{5, 6, 7}, {0, 0, 0}, {0, 8, 0}});
}

TEST_CASE("emission stands for colors that are black, and its picture for a plain white", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle = textured_triangle();
    triangle.attributes.set("COLOR_0", triangle.position);
    const auto material = [&](const std::string& entries)
    {
        set(triangle.sample, "materials", "[{" + entries + "}]");
        return read_sample(triangle.finished(), folder).materials.at(0);
    };
    const std::string light = R"("emissiveFactor": [1, 0.25, 0.125], "emissiveTexture": {"index": 0})";
    const std::string strong = light + R"(, "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}})";
    const auto base = [](const char* inside) { return std::string(R"(, "pbrMetallicRoughness": {)") + inside + "}"; };
    for (const std::string& taken : {strong, strong + base(R"("baseColorFactor": [0, 0, 0, 1])"),
                                     strong + base(R"("baseColorFactor": [0, 0, 0, 1], "baseColorTexture": {"index": 0})")})
    {
        CHECK(material(taken).color == Vec3f{1, 0.5F, 0.25F});
        CHECK(material(taken).picture == 0);
        CHECK_FALSE(material(taken).vertex_colors);
    }
    CHECK(material(light + base(R"("baseColorTexture": {"index": 0})")).color == Vec3f{1, 1, 1});
    const ModelMaterial gray = material(light + base(R"("baseColorFactor": [0.5, 0.5, 0.5, 1])"));
    CHECK(gray.color == Vec3f{0.5F, 0.5F, 0.5F});
    CHECK(gray.picture == ModelMaterial::no_picture);
    CHECK(gray.vertex_colors);
    const std::string lamp = R"("emissiveFactor": [0, 0, 1])";
    CHECK(material(lamp).color == Vec3f{1, 1, 1});
    CHECK(material(lamp + base(R"("baseColorFactor": [0, 0, 0, 1])")).color == Vec3f{0, 0, 1});
    CHECK(material(R"("emissiveTexture": {"index": 0})").picture == ModelMaterial::no_picture);
}

TEST_CASE("strips, fans and vertices in their order are triangles; points are left out", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle;
    triangle.attributes.set("POSITION", triangle.sample.add_accessor(
                                            std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 1, 1, 0}, "VEC3", 5126, 5));
    triangle.primitive.set("indices", triangle.sample.add_accessor(std::vector<std::uint8_t>{0, 1, 2, 3, 3}, "SCALAR", 5121, 5));
    triangle.primitive.set("mode", 5);
    const FileModel strip = read_sample(triangle.finished(), folder);
    CHECK(strip.mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}});
    CHECK(strip.report.degenerate_dropped == 1);
    triangle.primitive.set("mode", 6);
    CHECK(read_sample(triangle.finished(), folder).mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
    CHECK(read_sample(TriangleSample().finished(), folder).mesh.triangles == std::vector<Triangle>{{0, 1, 2}});

    GltfSample points = triangle.finished();
    Value meshes = points.rest.at("meshes");
    Value& primitives = *meshes.as_list()[0].find("primitives");
    primitives.as_list().push_back(primitives.as_list()[0]);
    primitives.as_list()[1].set("mode", 0);
    points.rest.set("meshes", meshes);
    const FileModel mixed = read_sample(points, folder);
    CHECK(mixed.mesh.triangles.size() == 2);
    CHECK_THAT(mixed.warnings.at(0), Contains("1 primitives of points or lines"));
    triangle.primitive.set("mode", 1);
    CHECK_THROWS_WITH(read_sample(triangle.finished(), folder),
                      Contains("a.glb: the scene has no triangles, only points and lines"));
}

TEST_CASE("vertex colors are linear light in floats, bytes or shorts", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    const std::vector<Rgb8> expected{{0, 188, 255}, {255, 0, 0}, {0, 0, 0}};
    TriangleSample floats;
    floats.attributes.set("COLOR_0",
                          floats.sample.add_accessor(std::vector<float>{0, 0.5F, 1, 1, 0, 0, 0, 0, 0}, "VEC3", 5126, 3));
    CHECK(read_sample(floats.finished(), folder).mesh.colors == expected);
    CHECK(read_sample(floats.finished(), folder).materials.at(0).vertex_colors);
    const std::vector<std::uint16_t> shorts{0, 32768, 65535, 9, 65535, 0, 0, 9, 0, 0, 0, 9};
    const std::vector<std::uint8_t> bytes{0, 128, 255, 9, 255, 0, 0, 9, 0, 0, 0, 9};
    const auto colors_of = [&](const auto& values, int type)
    {
        TriangleSample triangle;
        triangle.attributes.set("COLOR_0", triangle.sample.add_accessor(values, "VEC4", type, 3, true));
        return read_sample(triangle.finished(), folder).mesh.colors;
    };
    CHECK(colors_of(shorts, 5123) == expected);
    CHECK(colors_of(bytes, 5121) == expected);
}

TEST_CASE("materials: factor, wrap modes, second texcoords, transformed texcoords", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle = textured_triangle();
    set_material(triangle.sample);
    const FileModel plain = read_sample(triangle.finished(), folder);
    REQUIRE(plain.materials.size() == 1);
    CHECK(plain.materials[0].color == Vec3f{0.5F, 1, 0.25F});
    CHECK(plain.materials[0].picture == 0);
    CHECK(plain.materials[0].wrap_u == Wrap::mirror);
    CHECK(plain.materials[0].wrap_v == Wrap::clamp);
    CHECK(plain.mesh.texcoords == std::vector<Vec2f>{{0.25F, 1}, {1, 1}, {0, 0}});
    CHECK(read_sample(triangle.finished(), folder, false).materials.at(0).picture == ModelMaterial::no_picture);

    // The specification's example: the lower left quarter of the picture, turned by 90 degrees.
    set_material(triangle.sample, R"(, "extensions": {"KHR_texture_transform":
        {"offset": [0, 1], "rotation": 1.5707963267948966, "scale": [0.5, 0.5]}})");
    const auto turned = read_sample(triangle.finished(), folder).mesh.texcoords;
    CHECK(length(turned[0] - Vec2f{0, 0.125F}) < 1e-6F);
    CHECK(length(turned[1] - Vec2f{0, 0.5F}) < 1e-6F);
    CHECK(length(turned[2] - Vec2f{0.5F, 0}) < 1e-6F);

    triangle.attributes.set("TEXCOORD_1", triangle.sample.add_accessor(std::vector<std::uint8_t>{255, 255, 0, 0, 0, 255, 0, 0},
                                                                       "VEC2", 5121, 3, true));
    triangle.sample.views.back().set("byteStride", 4);
    triangle.sample.binary.resize(triangle.sample.binary.size() + 8);
    triangle.sample.views.back().set("byteLength", 12);
    set_material(triangle.sample, R"(, "extensions": {"KHR_texture_transform": {"texCoord": 1}})");
    CHECK(read_sample(triangle.finished(), folder).mesh.texcoords.at(0) == Vec2f{1, 0});

    set(triangle.sample, "materials", R"([{"extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [0.25, 0.5, 1, 1], "diffuseTexture": {"index": 0}}}}])");
    const FileModel older = read_sample(triangle.finished(), folder);
    CHECK(older.materials.at(0).color == Vec3f{0.25F, 0.5F, 1});
    CHECK(older.materials.at(0).picture == 0);

    triangle.attributes = Value::Map{{"POSITION", triangle.position}};
    const FileModel bare = read_sample(triangle.finished(), folder);
    CHECK(bare.materials.at(0).picture == ModelMaterial::no_picture);
    CHECK(bare.mesh.texcoords.empty());
    CHECK_THAT(bare.warnings.at(0), Contains("a picture but no texture coordinates"));
}

TEST_CASE("buffers and pictures lie in the file, beside it, or in its text", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle = textured_triangle();
    set_material(triangle.sample);
    GltfSample sample = triangle.finished();
    std::filesystem::create_directories(folder.path() / "data files");
    auto longer = sample.binary;
    longer.resize(longer.size() + 3);
    write_file(folder.path() / "data files/a b.bin", longer);
    write_file(folder.path() / "paper.png", stored_png::Codec().encode_png(Raster8(2, 2, 3, 5)));
    const auto text = [&](const std::string& buffer, const std::string& picture)
    {
        sample.rest.set("buffers", Value::List{Value::Map{{"byteLength", sample.binary.size()}, {"uri", buffer}}});
        sample.rest.set("images", Value::List{Value::Map{{"uri", picture}}});
        return to_json(sample.document());
    };
    const FileModel beside = read_text(text("data%20files/a%20b.bin", "paper.png"), folder);
    CHECK(beside.mesh.triangles.size() == 1);
    CHECK(beside.pictures.at(0).file == folder.path() / "paper.png");
    CHECK(beside.files_read ==
          std::vector<std::filesystem::path>{folder.path() / "data files/a b.bin", folder.path() / "paper.png"});

    // Nine floats of 0 and one byte more, as base64.
    TriangleSample inside;
    GltfSample data = inside.finished();
    data.rest.set("buffers", Value::List{Value::Map{{"byteLength", 36},
                                                    {"uri", "data:application/octet-stream;base64," + std::string(48, 'A')}}});
    CHECK(read_text(to_json(data.document()), folder).mesh.positions == std::vector<Vec3f>(3));
    sample.rest.set("images", Value::List{});
    CHECK_THROWS_WITH(read_text(text("data%20files/a%20b.bin", "data:image/png;base64,AAAA"), folder),
                      Contains("images[0]: not PNG, JPEG, WebP or AVIF"));
    CHECK_THROWS_WITH(read_text(text("data%20files/a%20b.bin", "data:image/tiff;base64,AAAA"), folder),
                      Contains("images[0]: expected \"data:image/png;base64"));
}

TEST_CASE("a picture or buffer that many name is held once", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    TriangleSample triangle = textured_triangle();
    GltfSample sample = triangle.finished();
    const Value::List primitives(3, sample.rest.at("meshes").as_list().at(0).at("primitives").as_list().at(0));
    sample.rest.set("meshes", Value::List{Value::Map{{"primitives", primitives}}});
    for (std::size_t i = 0; i < 3; ++i)
        sample.rest.find("meshes")->as_list()[0].find("primitives")->as_list()[i].set("material", i);
    set(sample, "materials", R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}, {"pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}}])");
    set(sample, "textures", R"([{"source": 0}, {"source": 1}, {"source": 2}])");
    const auto picture = sample.views.size() - 1;
    const auto of_views = [](std::size_t a, std::size_t b, std::size_t c)
    {
        Value::List images;
        for (const std::size_t view : {a, b, c})
            images.emplace_back(Value::Map{{"bufferView", view}, {"mimeType", "image/png"}});
        return images;
    };
    sample.rest.set("images", of_views(picture, picture, picture + 1));
    sample.views.push_back(sample.views.back());
    const FileModel once = read_sample(sample, folder);
    CHECK(once.pictures.size() == 1);
    CHECK(once.materials.size() == 3);

    // Three that each begin in the one before, and are nearly the whole file.
    GltfSample overlapping = sample;
    const std::size_t begin = overlapping.binary.size();
    for (const int byte : {0x89, 0x50, 0x4E, 0x47, 0x89, 0x50, 0x4E, 0x47, 0x89, 0x50, 0x4E, 0x47})
        overlapping.binary.push_back(static_cast<std::byte>(byte));
    overlapping.binary.resize(16 * begin);
    for (std::size_t i = 0; i < 3; ++i)
        overlapping.views.emplace_back(
            Value::Map{{"buffer", 0}, {"byteOffset", begin + 4 * i}, {"byteLength", 15 * begin - 4 * i}});
    const std::size_t last = overlapping.views.size() - 1;
    overlapping.rest.set("images", of_views(last - 2, last - 1, last));
    CHECK_THROWS_WITH(read_sample(overlapping, folder), Contains("images[1]: bufferView") && Contains("the pictures overlap"));

    write_file(folder.path() / "a.bin", sample.binary);
    const auto buffer = [&](const char* uri) { return Value::Map{{"byteLength", sample.binary.size()}, {"uri", uri}}; };
    sample.rest.set("buffers", Value::List{buffer("a.bin"), buffer("./a.bin")});
    CHECK_THROWS_WITH(read_text(to_json(sample.document()), folder),
                      Contains("buffers[1]: uri: another buffer has the same file"));
}

TEST_CASE("nothing outside of the file's folder is opened", "[scan.mesh]")
{
    const testing::TemporaryFolder outside;
    write_file(outside.path() / "secret.bin", std::string(4096, 'x'));
    std::filesystem::create_directories(outside.path() / "model");
    const auto file = outside.path() / "model/a.gltf";
    TriangleSample triangle;
    GltfSample sample = triangle.finished();
    const auto refused = [&](const std::string& uri, const std::string& reason)
    {
        sample.rest.set("buffers", Value::List{Value::Map{{"byteLength", 36}, {"uri", uri}}});
        write_file(file, to_json(sample.document()));
        CHECK_THROWS_WITH(scan_mesh::read_file_model(file, true), Contains("a.gltf: buffers[0]: uri: ") && Contains(reason));
    };
    std::filesystem::create_symlink(outside.path() / "secret.bin", outside.path() / "model/link.bin");
    std::filesystem::create_directory_symlink(outside.path(), outside.path() / "model/up");
    for (const std::string uri : {"../secret.bin", "..%2Fsecret.bin", "up/../../secret.bin", "..\\\\secret.bin",
                                  "https://example.org/a.bin", "file:///etc/passwd", "C:\\\\secret.bin"})
        refused(uri, "is not in ");
    refused((outside.path() / "secret.bin").string(), "is not in ");
    refused("link.bin", "is a link to a file outside");
    refused("up/secret.bin", "is a link to a file outside");
    refused("missing.bin", "is not in " + (outside.path() / "model").string());
    refused("a%00.bin", "is not a file name");
    refused("a%0A.bin", "is not a file name");
}
