#include "catch.h"
#include "check_glb.h"
#include "stored_png.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>

using namespace fresco;
using Catch::Contains;
using fresco::texturing::WeldedMesh;

namespace
{
WeldedMesh welded_square()
{
    WeldedMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.25F}, {0, 1, 0}};
    mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0.6F, 0.8F}, {0, 0, 1}};
    mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
}

std::vector<std::byte> picture()
{
    return stored_png::Codec().encode_png(Raster8(2, 2, 3, 9));
}

std::string file_of(const GlbOptions& options)
{
    return make_glb(welded_square(), picture(), options);
}

/// Replaces text of the JSON part by other text of the same length.
std::string error_after(std::string file, std::string_view from, std::string_view to)
{
    INFO(from << " becomes " << to);
    REQUIRE(from.size() == to.size());
    const std::size_t at = file.find(from);
    REQUIRE(at != std::string::npos);
    file.replace(at, from.size(), to);
    return fresco::testing::error_of([&] { read_glb(file, "a.glb"); });
}

std::vector<GlbOptions> all_options()
{
    std::vector<GlbOptions> result;
    for (const GltfMaterial material : {GltfMaterial::unlit, GltfMaterial::pbr})
        for (const bool quantize : {false, true})
            for (const bool compress : {false, true})
                result.push_back({material, {-0.6, 0, 0, 0.8}, "image/png", quantize, compress});
    return result;
}
}  // namespace

TEST_CASE("what was written passes its check, and a check against anything else fails")
{
    for (const GlbOptions& options : all_options())
    {
        const GlbModel model = read_glb(file_of(options), "a.glb");
        CHECK(check_glb(model, welded_square(), picture(), options).position_m <= 0.5 / 65535);
        WeldedMesh other = welded_square();
        other.positions[2].z += 1e-4F;
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 2 is 0.0"));
        other = welded_square();
        other.texcoords[1].y = 0.01F;
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 1 has a different texcoord"));
        other = welded_square();
        std::swap(other.indices[4], other.indices[5]);
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("triangle 1 differs"));
        CHECK_THROWS_WITH(check_glb(model, welded_square(), {}, options), Contains("the picture differs"));
        GlbOptions other_origin = options;
        other_origin.origin.set("stages", Value::List{});
        CHECK_THROWS_WITH(check_glb(model, welded_square(), picture(), other_origin), Contains("asset.extras differs"));
        if (options.material == GltfMaterial::pbr)
        {
            other = welded_square();
            other.normals[0] = {0, 1, 0};
            CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 0 has a different normal"));
        }
    }
}

TEST_CASE("entries that lie are named")
{
    const auto refused = [](const GlbOptions& options, std::string_view from, std::string_view to, const std::string& reason)
    { CHECK_THAT(error_after(file_of(options), from, to), Contains("a.glb: ") && Contains(reason)); };
    const GlbOptions plain{GltfMaterial::unlit, {0, 0, 0, 1}, "image/png", false, false};
    CHECK(error_after(file_of(plain), "\"count\":6", "\"count\":6").empty());
    refused(plain, "\"count\":6", "\"count\":9", "accessors[0]: 9 rows of 2 bytes at byte 0 do not fit");
    refused(plain, "\"count\":6", "\"count\":5", "expected a multiple of 3");
    refused(plain, "\"max\":[1.0", "\"max\":[2.0", "accessors[1]: min and max differ from the values");
    refused(plain, "\"max\":[1.0,1.0", "\"max\":[1.01111", "accessors[1]: min and max: too few numbers");
    refused(plain, "\"componentType\":5123", "\"componentType\":5129", "componentType 5129");
    refused(plain, "\"componentType\":5123", "\"componentType\":5122", "expected unsigned integers");
    refused(plain, "\"byteOffset\":12", "\"byteOffset\":10", "accessors[1]: its bytes do not start at a multiple of 4");
    refused(plain, "\"POSITION\":1", "\"POSITIAN\":1", "POSITION is missing");
    refused(plain, "image/png", "image/pxg", "images[0]: mimeType");
    refused(plain, "image/png\"", "image/jpeg", "JSON");
    refused(plain, "\"source\":0", "\"source\":1", "the picture is unused");
    refused(plain, "KHR_materials_unlit\"]", "KHR_materials_unlot\"]", "do not agree");
    refused(plain, "\"mode\":4", "\"mode\":5", "expected triangles (4)");
    refused(plain, "[{\"byteLength\":1", "[{\"byteLength\":9", "buffers[0]: byteLength");
    refused({GltfMaterial::unlit, {0, 0, 0, 1}, "image/png", true, false}, "Required\":[\"KHR_mesh", "Required\":[\"KHR_mosh",
            "KHR_mosh_quantization, which is not supported");
    const GlbOptions packed{GltfMaterial::pbr, {-0.6, 0, 0, 0.8}, "image/png", true, true};
    CHECK(error_after(file_of(packed), "\"count\":6", "\"count\":6").empty());
    refused(packed, "Required\":[\"KHR_mesh_quantization\",\"EXT_meshopt_compression\"]",
            "Required\":[\"KHR_mesh_quantization\",\"KHR_materials_unlit\"    ]",
            "expected EXT_meshopt_compression, which bufferViews use");
    refused(packed, "\"byteStride\":2,\"count\":6", "\"byteStride\":2,\"count\":3", "bufferViews[0]: ");
    refused(packed, "\"byteStride\":2,\"count\":6", "\"byteStride\":9,\"count\":6", "does not hold 6 indices of 9 bytes");
    refused(packed, "\"byteStride\":8,\"count\":4", "\"byteStride\":0,\"count\":4", "does not hold 4 rows of 0 bytes");
    refused(packed, "\"byteStride\":8,\"count\":4", "\"byteStride\":8,\"count\":9", "bufferViews[1]: ");
    refused(packed, "\"mode\":\"TRIANGLES\"", "\"mode\":\"ATTRIBUTE\"",
            "bufferViews[0]: EXT_meshopt_compression: byte 0 of buffer 0: mode: expected ATTRIBUTES, "
            "TRIANGLES or INDICES");
}

TEST_CASE("a cut file is refused at every length, and flipped bytes give an error or a mesh in range")
{
    for (const GlbOptions& options : all_options())
    {
        const auto file = file_of(options);
        for (std::size_t length = 0; length < file.size(); ++length)
            CHECK_THROWS_AS(read_glb(std::string_view(file).substr(0, length), "a.glb"), Error);
        Random random{7};
        for (int i = 0; i < 500; ++i)
        {
            auto flipped = file;
            flipped[random.below(flipped.size())] ^= static_cast<char>(1U << random.below(8));
            try
            {
                const GlbModel model = read_glb(flipped, "a.glb");
                for (const std::uint32_t index : model.indices)
                    CHECK(index < model.positions.size());
            }
            catch (const Error&)
            {
            }
        }
    }
}
