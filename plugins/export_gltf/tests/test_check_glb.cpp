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
