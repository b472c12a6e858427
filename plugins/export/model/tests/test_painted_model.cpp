#include "catch.h"
#include "model_samples.h"
#include "painted_model.h"

#include <fresco/gltf/gltf_file.h>
#include <fresco/testing.h>
#include <fresco/texturing/glb.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>

using namespace fresco;
using namespace export_model;

namespace
{

const std::string paint = "the painted picture";

/// An atlas of quads, two triangles each, side by side; the second triangle of those in `cut` lies apart from the first.
Mesh atlas_of(std::size_t quads, const std::vector<std::size_t>& cut = {})
{
    Mesh mesh;
    mesh.triangles.resize(2 * quads);
    for (std::size_t quad = 0; quad < quads; ++quad)
        for (const std::size_t corner : {0, 1, 2, 0, 2, 3})
        {
            const bool is_apart = mesh.texcoords.size() % 6 >= 3 && std::ranges::find(cut, quad) != cut.end();
            const auto uv = model_samples::corner_uvs[corner];
            mesh.texcoords.push_back(
                {(static_cast<float>(quad) + uv[0] * 0.5F + (is_apart ? 0.5F : 0)) / static_cast<float>(quads), uv[1]});
        }
    return mesh;
}

struct Painted : testing::TemporaryFolder
{
    std::vector<bool> cutout;

    Painting painting(const Mesh& atlas, bool keeps_uvs = false)
    {
        return {.atlas = atlas,
                .keeps_uvs = keeps_uvs,
                .picture =
                    [this](const std::vector<bool>& faces)
                {
                    cutout = faces;
                    const auto bytes = std::as_bytes(std::span(paint));
                    return Picture{{bytes.begin(), bytes.end()}, ".png"};
                },
                .name = "painted",
                .origin = Value::Map{{"stages", Value::List{}}}};
    }

    std::filesystem::path glb_box(const std::function<void(Value&)>& change = {})
    {
        const auto file = model_samples::write_glb_box(path());
        gltf::GltfFile box = gltf::load_gltf(read_file(file), {});
        if (change)
            change(box.document);
        const auto& bytes = box.model.buffers.at(0).data;
        write_file(file, texturing::glb_of(box.document, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
        return file;
    }

    Mesh read_back(const PaintedFiles& files)
    {
        for (const auto& [name, contents] : files.files)
            write_file(path() / name, contents);
        MeshMaterials materials;
        return read_mesh(path() / files.files[0].first, {}, nullptr, &materials);
    }
};

gltf::GltfFile loaded(const std::string& glb)
{
    return gltf::load_gltf(std::as_bytes(std::span(glb)), {});
}

Value& entry_of(Value& document, std::initializer_list<const char*> path)
{
    Value* at = &document;
    for (const std::string step : path)
        at = step[0] >= '0' && step[0] <= '9' ? &at->as_list().at(std::stoul(step)) : at->find(step);
    return *at;
}

void remove_entry(Value& map, std::string_view key)
{
    std::erase_if(map.as_map(), [&](const Value::Entry& each) { return each.first == key; });
}

/// The rows of an attribute at a primitive's corners, in the order of its triangles.
std::vector<std::vector<double>> at_corners(const gltf::GltfFile& file, std::size_t mesh, std::size_t primitive,
                                            const std::string& name)
{
    const auto& source = file.model.meshes.at(mesh).primitives.at(primitive);
    const auto rows = gltf::accessor_rows(file.model, source.attributes.at(name), 1, 16);
    std::vector<std::vector<double>> all;
    for (const std::uint32_t v : gltf::triangle_indices(file.model, source.indices, source.mode, rows.count))
    {
        all.emplace_back();
        for (std::size_t c = 0; c < rows.components; ++c)
            all.back().push_back(rows.at(v, c));
    }
    return all;
}

std::string image_bytes(const gltf::GltfFile& file, std::size_t image)
{
    const auto bytes = gltf::view_bytes(file.model, static_cast<std::size_t>(file.images.at(image).buffer_view));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TEST_CASE("A second set of texcoords: corners and triangles stay, vertices are copied along seams only")
{
    Painted test;
    const auto file = test.glb_box();
    const auto before = gltf::load_gltf(read_file(file), {});
    const Mesh atlas = atlas_of(6, {2});
    const PaintedFiles result = painted_gltf(file, test.painting(atlas));
    REQUIRE(result.files.size() == 1);
    CHECK(result.files[0].first == "painted.glb");
    CHECK(result.vertices_added == 2);
    const auto after = loaded(result.files[0].second);
    for (std::size_t side = 0; side < 6; ++side)
    {
        for (const char* const name : {"POSITION", "TEXCOORD_0"})
            CHECK(at_corners(after, 0, side, name) == at_corners(before, 0, side, name));
        const auto uv = at_corners(after, 0, side, "TEXCOORD_1");
        for (std::size_t corner = 0; corner < 6; ++corner)
        {
            const Vec2f expected = atlas.texcoords[6 * side + corner];
            CHECK(uv[corner] == std::vector<double>{double{expected.x}, double{1 - expected.y}});
        }
        const auto& primitive = after.model.meshes[0].primitives[side];
        CHECK(after.model.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))].count == (side == 2 ? 6 : 4));
        const auto& material = after.model.materials[static_cast<std::size_t>(primitive.material)];
        CHECK(material.name == "side " + std::to_string(side));
        CHECK(material.pbrMetallicRoughness.baseColorTexture.texCoord == 1);
        CHECK(material.pbrMetallicRoughness.metallicFactor == 0);
    }
    REQUIRE(after.images.size() == 1);
    CHECK(image_bytes(after, 0) == paint);
    CHECK(after.document.at("asset").at("extras").find("stages") != nullptr);
    // The views of what was replaced are gone: positions, texcoords and indices of six sides, a new set each, and the picture.
    CHECK(after.model.bufferViews.size() == 6 * 4 + 1);
}

TEST_CASE("Skins and morph targets follow where vertices are copied")
{
    Painted test;
    model_samples::GltfSample sample;
    using List = Value::List;
    using Map = Value::Map;
    const auto floats = [&](const std::vector<float>& values, const char* type)
    { return sample.add_accessor(values, type, 5126, 4); };
    const Map attributes{
        {"POSITION", floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3")},
        {"JOINTS_0",
         sample.add_accessor(std::vector<std::uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0}, "VEC4", 5121, 4)},
        {"WEIGHTS_0", floats({1, 0, 0, 0, 1, 0, 0, 0, 0.25F, 0.75F, 0, 0, 0.5F, 0.5F, 0, 0}, "VEC4")}};
    const Map bulge{{"POSITION", floats({0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3")}};
    const int indices = sample.add_accessor(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 5123, 6);
    sample.rest.set(
        "meshes",
        List{Map{{"weights", List{0.5}},
                 {"primitives",
                  List{Map{{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"targets", List{bulge}}}}}}});
    sample.rest.set("materials", List{Map{{"name", "cloth"}}});
    sample.rest.set("nodes", List{Map{{"mesh", 0}, {"skin", 0}}, Map{{"name", "hip"}}, Map{{"name", "knee"}}});
    sample.rest.set("skins", List{Map{{"joints", List{1, 2}}}});
    sample.rest.set("scenes", List{Map{{"nodes", List{0, 1, 2}}}});
    const auto file = test.path() / "figure.glb";
    write_file(file, sample.glb());

    const auto before = gltf::load_gltf(read_file(file), {});
    const PaintedFiles result = painted_gltf(file, test.painting(atlas_of(1, {0})));
    CHECK(result.vertices_added == 2);
    const auto after = loaded(result.files[0].second);
    for (const char* const name : {"POSITION", "JOINTS_0", "WEIGHTS_0"})
        CHECK(at_corners(after, 0, 0, name) == at_corners(before, 0, 0, name));
    const auto bulged = [](const gltf::GltfFile& model)
    {
        const auto& primitive = model.model.meshes[0].primitives[0];
        const auto rows = gltf::accessor_rows(model.model, primitive.targets.at(0).at("POSITION"), 1, 16);
        std::vector<double> heights;
        for (const std::uint32_t v : gltf::triangle_indices(model.model, primitive.indices, primitive.mode, rows.count))
            heights.push_back(rows.at(v, 2));
        return heights;
    };
    CHECK(bulged(after) == std::vector<double>{0, 1, 2, 0, 2, 3});
    CHECK(after.document.at("skins") == before.document.at("skins"));
    CHECK(after.model.nodes[0].skin == 0);
    CHECK(after.model.meshes[0].weights == std::vector<double>{0.5});
}

TEST_CASE("With its own texcoords, a model keeps every byte but its picture")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            document.set("extras", Value::Map{{"bufferView", "not one"}});
            entry_of(document, {"nodes", "0"}).set("extensions", Value::Map{{"FOREIGN_thing", Value::Map{{"a", 1}}}});
            document.set("extensionsUsed", Value::List{"FOREIGN_thing"});
        });
    const auto before = gltf::load_gltf(read_file(file), {});
    const auto after = loaded(painted_gltf(file, test.painting(atlas_of(6), true)).files[0].second);
    CHECK(after.document.at("meshes") == before.document.at("meshes"));
    CHECK(after.document.at("nodes") == before.document.at("nodes"));
    CHECK(after.document.at("extras") == before.document.at("extras"));
    for (std::size_t side = 0; side < 6; ++side)
        for (const char* const name : {"POSITION", "TEXCOORD_0"})
            CHECK(at_corners(after, 0, side, name) == at_corners(before, 0, side, name));
    // An extension that is not known may name pictures by their numbers, so none is taken out.
    CHECK(after.images.size() == 7);
    CHECK(image_bytes(after, 6) == paint);
    CHECK(after.model.materials[5].pbrMetallicRoughness.baseColorTexture.texCoord == 0);
}

TEST_CASE("Every node gets a mesh of its own, and the faces of a mirrored one are found turned over")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            const Value mirrored = Value::Map{{"mesh", 0}, {"scale", Value::List{-1, 1, 1}}, {"name", "twin"}};
            document.find("nodes")->as_list().push_back(mirrored);
            entry_of(document, {"scenes", "0", "nodes"}).as_list().push_back(1);
        });
    const Mesh atlas = atlas_of(12);
    const auto after = loaded(painted_gltf(file, test.painting(atlas)).files[0].second);
    REQUIRE(after.model.meshes.size() == 2);
    CHECK(after.model.nodes[1].mesh == 1);
    CHECK(after.model.nodes[1].name == "twin");
    const auto uv = at_corners(after, 1, 0, "TEXCOORD_1");
    for (const auto& [corner, of_atlas] : std::map<std::size_t, std::size_t>{{0, 0}, {1, 2}, {2, 1}, {3, 3}, {4, 5}, {5, 4}})
        CHECK(uv[corner][0] == double{atlas.texcoords[36 + of_atlas].x});
    CHECK(at_corners(after, 1, 0, "POSITION") == at_corners(after, 0, 0, "POSITION"));
}

TEST_CASE("Copies of a mesh by EXT_mesh_gpu_instancing become nodes, each with its own place in the picture")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            // The four corners of a side are where the copies stand.
            const Value places = entry_of(document, {"meshes", "0", "primitives", "0", "attributes", "POSITION"});
            const Value instancing = Value::Map{{"attributes", Value::Map{{"TRANSLATION", places}}}};
            entry_of(document, {"nodes", "0"}).set("extensions", Value::Map{{"EXT_mesh_gpu_instancing", instancing}});
            document.set("extensionsUsed", Value::List{"EXT_mesh_gpu_instancing"});
        });
    const Mesh atlas = atlas_of(24);
    const auto after = loaded(painted_gltf(file, test.painting(atlas)).files[0].second);
    CHECK(after.model.nodes[0].mesh == -1);
    CHECK(after.model.nodes[0].extensions.empty());
    CHECK(after.model.nodes[0].children == std::vector<int>{1, 2, 3, 4});
    CHECK(after.model.extensionsUsed.empty());
    // scan.mesh reads the copies of a primitive one after the other.
    for (std::size_t copy = 0; copy < 4; ++copy)
    {
        const auto& node = after.model.nodes[1 + copy];
        CHECK(node.mesh == static_cast<int>(copy));
        const Vec3f place = model_samples::Box::corners(0)[copy];
        CHECK(std::vector<double>(node.matrix.begin() + 12, node.matrix.end()) ==
              std::vector<double>{double{place.x}, double{place.y}, double{place.z}, 1});
        CHECK(node.matrix[0] == 1);
        for (std::size_t side = 0; side < 6; ++side)
        {
            CHECK(at_corners(after, copy, side, "POSITION") == at_corners(after, 0, side, "POSITION"));
            const auto uv = at_corners(after, copy, side, "TEXCOORD_1");
            for (std::size_t corner = 0; corner < 6; ++corner)
                CHECK(uv[corner][0] == double{atlas.texcoords[6 * (4 * side + copy) + corner].x});
        }
    }
}

TEST_CASE("Variants of a model keep their materials, and the one that is painted shows the painting")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            const auto swap = [&](const char* side, int own, int other)
            {
                const Value first = Value::Map{{"material", own}, {"variants", Value::List{0}}};
                const Value second = Value::Map{{"material", other}, {"variants", Value::List{1}}};
                entry_of(document, {"meshes", "0", "primitives", side})
                    .set("extensions",
                         Value::Map{{"KHR_materials_variants", Value::Map{{"mappings", Value::List{first, second}}}}});
            };
            swap("0", 0, 1);
            swap("1", 1, 0);
            document.set("extensionsUsed", Value::List{"KHR_materials_variants"});
        });
    const auto before = gltf::load_gltf(read_file(file), {});
    auto after = loaded(painted_gltf(file, test.painting(atlas_of(6))).files[0].second);
    for (const char* const side : {"0", "1"})
    {
        Value& primitive = entry_of(after.document, {"meshes", "0", "primitives", side});
        Value& mappings = entry_of(primitive, {"extensions", "KHR_materials_variants", "mappings"});
        CHECK(entry_of(mappings, {"0", "material"}) == primitive.at("material"));
        const auto other = static_cast<std::size_t>(entry_of(mappings, {"1", "material"}).as_int());
        const auto& picture = after.model.materials.at(other).pbrMetallicRoughness.baseColorTexture;
        CHECK(picture.texCoord == 0);
        const auto& old = before.model.materials.at(side[0] == '0' ? 1 : 0);
        CHECK(after.model.materials[other].name == old.name);
        CHECK(image_bytes(after, static_cast<std::size_t>(
                                     after.model.textures[static_cast<std::size_t>(picture.index)].source)) != paint);
    }
}

TEST_CASE("What multiplied the picture goes, and everything else of materials stays")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            Value& material = entry_of(document, {"materials", "0"});
            material.find("pbrMetallicRoughness")->set("baseColorFactor", Value::List{0.5, 0.25, 1.0, 0.75});
            material.set("alphaMode", "MASK");
            material.set("normalTexture", Value::Map{{"index", 0}});
            entry_of(document, {"materials", "1"})
                .set("extensions", Value::Map{{"KHR_materials_pbrSpecularGlossiness",
                                               Value::Map{{"diffuseTexture", Value::Map{{"index", 1}}},
                                                          {"diffuseFactor", Value::List{0.5, 0.5, 0.5, 1.0}}}}});
            Value& primitives = entry_of(document, {"meshes", "0", "primitives"});
            entry_of(primitives, {"2", "attributes"}).set("COLOR_0", entry_of(primitives, {"2", "attributes", "POSITION"}));
            // Colors whose alpha counts become white and keep it.
            entry_of(primitives, {"0", "attributes"}).set("COLOR_0", document.find("accessors")->as_list().size());
            document.find("accessors")
                ->as_list()
                .push_back(
                    Value::Map{{"bufferView", 0}, {"componentType", 5121}, {"normalized", true}, {"count", 4}, {"type", "VEC4"}});
            // Points of a material that a side has, too, are not painted.
            Value points = primitives.as_list()[3];
            points.set("mode", 0);
            primitives.as_list().push_back(points);
            remove_entry(primitives.as_list()[4], "material");
        });
    const auto after = loaded(painted_gltf(file, test.painting(atlas_of(6))).files[0].second);
    const auto& first = after.document.at("materials").as_list()[0];
    CHECK(first.at("pbrMetallicRoughness").at("baseColorFactor") == Value(Value::List{1.0, 1.0, 1.0, 0.75}));
    const auto normal = static_cast<std::size_t>(first.at("normalTexture").at("index").as_int());
    const auto normal_image = static_cast<std::size_t>(after.document.at("textures").as_list()[normal].at("source").as_int());
    CHECK(image_bytes(after, normal_image).starts_with("\x89PNG"));
    const auto& older = after.document.at("materials").as_list()[1].at("extensions").at("KHR_materials_pbrSpecularGlossiness");
    CHECK(older.at("diffuseTexture").at("index") == first.at("pbrMetallicRoughness").at("baseColorTexture").at("index"));
    CHECK(older.at("diffuseFactor") == Value(Value::List{1.0, 1.0, 1.0, 1.0}));
    const auto& primitives = after.model.meshes[0].primitives;
    CHECK(primitives[2].attributes.count("COLOR_0") == 0);
    for (const auto& color : at_corners(after, 0, 0, "COLOR_0"))
        CHECK((color[0] == 1 && color[1] == 1 && color[2] == 1));
    CHECK(primitives[6].material == 3);
    CHECK(primitives[3].material > 5);
    CHECK(primitives[4].material > 5);
    std::vector<bool> masked(12, false);
    masked[0] = masked[1] = true;
    CHECK(test.cutout == masked);
    // Left: the pictures of the normals, of the points and of the material that nothing shows, and the painting.
    CHECK(after.images.size() == 4);
}

TEST_CASE("A room whose colors are all emission is painted there")
{
    Painted test;
    const auto file = test.glb_box(
        [](Value& document)
        {
            Value& material = entry_of(document, {"materials", "0"});
            material.set("emissiveTexture", Value::Map{{"index", 0}});
            material.set("emissiveFactor", Value::List{0.5, 0.5, 0.5});
            material.set("pbrMetallicRoughness", Value::Map{{"baseColorFactor", Value::List{0, 0, 0, 1}}});
        });
    const auto after = loaded(painted_gltf(file, test.painting(atlas_of(6))).files[0].second);
    const auto& material = after.document.at("materials").as_list()[0];
    CHECK(material.at("emissiveFactor") == Value(Value::List{1.0, 1.0, 1.0}));
    CHECK(material.at("emissiveTexture").at("index") ==
          after.document.at("materials").as_list()[1].at("pbrMetallicRoughness").at("baseColorTexture").at("index"));
    CHECK(material.at("pbrMetallicRoughness") == Value(Value::Map{{"baseColorFactor", Value::List{0, 0, 0, 1}}}));
}

TEST_CASE("A model that cannot be painted is refused by name")
{
    Painted test;
    const auto error = [&](const std::filesystem::path& file, const Mesh& atlas)
    { return testing::error_of([&] { painted_gltf(file, test.painting(atlas)); }); };
    CHECK_THAT(error(test.glb_box(), atlas_of(5)), Contains("has 11 triangles or more, the painted mesh has 10"));
    CHECK_THAT(error(test.glb_box(), atlas_of(7)), Contains("has 12 triangles or more, the painted mesh has 14"));
    const auto changed = [&](const std::function<void(Value&)>& change) { return error(test.glb_box(change), atlas_of(6, {0})); };
    CHECK_THAT(changed([](Value& d) { entry_of(d, {"nodes", "0"}).set("mesh", 9); }), Contains("mesh 9 of 1"));
    CHECK_THAT(changed(
                   [](Value& d)
                   {
                       Value& short_one = entry_of(d, {"accessors", "1"});
                       d.find("accessors")->as_list().push_back(short_one);
                       d.find("accessors")->as_list().back().set("count", 1);
                       entry_of(d, {"meshes", "0", "primitives", "0", "attributes"}).set("_OTHER", 18);
                   }),
               Contains("accessors[18]") && Contains("4 vertices"));
    CHECK_THAT(changed(
                   [](Value& d) {
                       entry_of(d, {"materials", "0"}).set("normalTexture", Value::Map{{"index", 99}});
                   }),
               Contains("an index names an entry that is not there"));
}

TEST_CASE("An OBJ keeps its vertices, faces and groups")
{
    Painted test;
    const auto file = model_samples::write_obj_box(test.path());
    MeshMaterials materials;
    const Mesh before = read_mesh(file, {}, nullptr, &materials);

    const PaintedFiles kept = painted_obj(file, test.painting(atlas_of(6), true));
    std::string expected = read_text_file(file);
    const std::string library = "mtllib box.mtl\n";
    expected.erase(expected.find(library), library.size());
    CHECK(kept.files[0].second == "mtllib painted.mtl\n" + expected);
    // Macintosh ends of lines are written as others.
    std::string with_returns = read_text_file(file);
    std::ranges::replace(with_returns, '\n', '\r');
    write_file(test.path() / "mac.obj", with_returns);
    CHECK(painted_obj(test.path() / "mac.obj", test.painting(atlas_of(6), true)).files[0].second == kept.files[0].second);
    REQUIRE(kept.files.size() == 3);
    CHECK_THAT(kept.files[1].second,
               Contains("newmtl side 5\nKd 1 1 1\nmap_Kd painted.png\nillum 1\n") && !Contains("0.8") && !Contains("side 0.png"));
    CHECK(kept.files[2] == std::pair<std::string, std::string>{"painted.png", paint});

    for (const bool is_cut : {false, true})
    {
        const Mesh atlas = atlas_of(6, is_cut ? std::vector<std::size_t>{4} : std::vector<std::size_t>{});
        const PaintedFiles second = painted_obj(file, test.painting(atlas));
        CHECK(second.polygons_split == (is_cut ? 1 : 0));
        const Mesh after = test.read_back(second);
        CHECK(after.positions == before.positions);
        CHECK(after.triangles == before.triangles);
        CHECK(after.texcoords == atlas.texcoords);
    }
}

TEST_CASE("An OBJ's other pictures, placing and colors: kept with its texture coordinates, left out with others")
{
    Painted test;
    write_file(test.path() / "painted.png", std::string("the old picture"));
    write_file(test.path() / "my bumps.png", std::string("bumps"));
    write_file(test.path() / "a.mtl",
               std::string("newmtl one\nmap_Kd -s 2 2 1 -o 0.5 0 0 painted.png\nmap_Ka painted.png\nbump -bm 0.5 my bumps.png\n"
                           "map_Ks nothing.png\nnewmtl two\nKd 0.25 0.5 0.75\n"));
    write_file(test.path() / "a.obj",
               std::string("mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
                           "l 1/1 2/2\nusemtl one\nf 1/1 2/2\\\n 3/3\nusemtl two\nf\\\n 1 3 +4\n"));
    const auto kept = painted_obj(test.path() / "a.obj", test.painting(atlas_of(1), true));
    CHECK_THAT(kept.files[0].second, Contains("v 1 1 0\n") && Contains("l 1/1 2/2") && Contains("f 1/1 2/2\\\n 3/3\n"));
    CHECK(kept.files[1].second == "newmtl one\nKd 1 1 1\nmap_Kd -s 2 2 1 -o 0.5 0 0 painted.png\nmap_Ka painted_1.png\n"
                                  "bump -bm 0.5 painted_2.png\n\nnewmtl two\nKd 0.25 0.5 0.75\n\n");
    REQUIRE(kept.files.size() == 5);
    CHECK(kept.files[2].second == paint);
    CHECK(kept.files[3] == std::pair<std::string, std::string>{"painted_1.png", "the old picture"});
    CHECK(kept.files[4].second == "bumps");
    CHECK_THAT(kept.messages.back(), Contains("1 picture other"));

    const auto second = painted_obj(test.path() / "a.obj", test.painting(atlas_of(1)));
    CHECK(second.files.size() == 3);
    CHECK_THAT(second.files[0].second, Contains("l 1 2\n") && Contains("f 1/1 2/2 3/3\n") && Contains("f 1/1 3/3 +4/4\n"));
    CHECK_THAT(second.files[1].second, Contains("newmtl two\nKd 1 1 1\nmap_Kd painted.png\n"));
    CHECK_THAT(second.messages.back(), Contains("3 pictures other"));
}

TEST_CASE("A PLY keeps its vertices, faces and other properties")
{
    Painted test;
    const auto ascii = model_samples::write_ply_box(test.path());
    std::string text = read_text_file(ascii);
    text.replace(text.find("property int texnumber"), 22, "property int texnumber\nproperty short mark");
    for (std::size_t at = text.find(" 8 0 0"); at != std::string::npos; at = text.find(" 8 0 0", at + 1))
        text.insert(text.find('\n', at), " -7");
    write_file(ascii, text);
    Mesh plain = testing::box();
    plain.texcoords.assign(3 * plain.triangles.size(), {});
    const auto binary = test.path() / "binary.ply";
    write_file(binary, to_ply(plain));
    for (const auto& file : {ascii, binary})
    {
        MeshMaterials materials;
        const Mesh before = read_mesh(file, {}, nullptr, &materials);
        for (const bool is_cut : {false, true})
        {
            const Mesh atlas = atlas_of(6, is_cut ? std::vector<std::size_t>{4} : std::vector<std::size_t>{});
            const PaintedFiles second = painted_ply(file, test.painting(atlas));
            CHECK(second.polygons_split == (is_cut && file == ascii ? 1 : 0));
            const Mesh after = test.read_back(second);
            CHECK(after.positions == before.positions);
            CHECK(after.triangles == before.triangles);
            CHECK(after.texcoords == atlas.texcoords);
            const auto& written = second.files[0].second;
            CHECK_THAT(written, Contains("comment TextureFile painted.png\n") && !Contains("texnumber"));
            CHECK((file == binary || written.find(" -7 ") != std::string::npos));
        }
        const std::string all = read_text_file(file);
        const std::string kept = painted_ply(file, test.painting(atlas_of(6), true)).files[0].second;
        const auto body = [](const std::string& ply) { return ply.substr(ply.find("end_header")); };
        CHECK(body(kept) == body(all));
        CHECK(test.read_back(painted_ply(file, test.painting(atlas_of(6), true))).texcoords == before.texcoords);
    }
    write_file(ascii, text.substr(0, text.size() - 20));
    CHECK_THROWS_AS(painted_ply(ascii, test.painting(atlas_of(6))), Error);
}
