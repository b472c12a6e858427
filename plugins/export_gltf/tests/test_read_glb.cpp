#include "check_glb.h"
#include "compression.h"
#include "stored_png.h"

#include <fresco/error.h>
#include <fresco/random.h>

#include <catch2/catch.hpp>

using namespace fresco;
using Catch::Contains;
using fresco::texturing::WeldedMesh;

namespace
{
WeldedMesh square()
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

std::vector<std::byte> file_of(const GlbOptions& options)
{
    return make_glb(square(), picture(), options);
}

/// Replaces text of the JSON part by other text of the same length.
std::string error_after(std::vector<std::byte> file, std::string_view from, std::string_view to)
{
    REQUIRE(from.size() == to.size());
    const auto* const text = reinterpret_cast<const char*>(file.data());
    const std::size_t at = std::string_view(text, file.size()).find(from);
    REQUIRE(at != std::string_view::npos);
    std::ranges::transform(to, file.begin() + static_cast<std::ptrdiff_t>(at), [](char c) { return static_cast<std::byte>(c); });
    try
    {
        read_glb(file, "a.glb");
    }
    catch (const Error& error)
    {
        return error.what();
    }
    return "";
}

std::vector<GlbOptions> all_options()
{
    std::vector<GlbOptions> result;
    for (const GltfMaterial material : {GltfMaterial::unlit, GltfMaterial::pbr})
        for (const bool quantize : {false, true})
            for (const bool compress : {false, true})
                if (!compress || can_compress())
                    result.push_back({material, GltfUp::z, "image/png", quantize, compress});
    return result;
}
}  // namespace

TEST_CASE("what was written passes its check, and a check against anything else fails")
{
    for (const GlbOptions& options : all_options())
    {
        const GlbModel model = read_glb(file_of(options), "a.glb");
        CHECK(check_glb(model, square(), picture(), options).position_m <= 0.5 / 65535);
        WeldedMesh other = square();
        other.positions[2].z += 1e-4F;
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 2 is 0.0"));
        other = square();
        other.texcoords[1].y = 0.01F;
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 1 has another texcoord"));
        other = square();
        std::swap(other.indices[4], other.indices[5]);
        CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("triangle 1 is another"));
        CHECK_THROWS_WITH(check_glb(model, square(), {}, options), Contains("the picture is another"));
        if (options.material == GltfMaterial::pbr)
        {
            other = square();
            other.normals[0] = {0, 1, 0};
            CHECK_THROWS_WITH(check_glb(model, other, picture(), options), Contains("vertex 0 has another normal"));
        }
    }
}

TEST_CASE("entries that lie are named")
{
    const auto plain = file_of({});
    CHECK(error_after(plain, "\"count\":6", "\"count\":6").empty());
    CHECK_THAT(error_after(plain, "\"count\":6", "\"count\":9"), Contains("9 rows do not fit into their view"));
    CHECK_THAT(error_after(plain, "\"count\":6", "\"count\":5"), Contains("three for each triangle"));
    CHECK_THAT(error_after(plain, "\"max\":[1.0", "\"max\":[2.0"),
               Contains("accessors[1]: min and max are not those of the values"));
    CHECK_THAT(error_after(plain, "\"componentType\":5123", "\"componentType\":5129"), Contains("componentType: 5129"));
    CHECK_THAT(error_after(plain, "image/png", "image/pxg"), Contains("mimeType"));
    CHECK_THAT(error_after(plain, "KHR_materials_unlit\"]", "KHR_materials_unlot\"]"), Contains("do not agree"));
    const auto small = file_of({GltfMaterial::unlit, GltfUp::keep, "image/png", true, false});
    CHECK_THAT(error_after(small, "Required\":[\"KHR_mesh", "Required\":[\"KHR_mosh"),
               Contains("KHR_mosh_quantization is unknown"));
}

TEST_CASE("a cut file is refused at every length, and flipped bytes give an error or a mesh in range")
{
    for (const GlbOptions& options : all_options())
    {
        const auto file = file_of(options);
        for (std::size_t length = 0; length < file.size(); ++length)
            CHECK_THROWS_AS(read_glb(std::span(file).first(length), "a.glb"), Error);
        Random random{7};
        for (int i = 0; i < 500; ++i)
        {
            auto flipped = file;
            flipped[random.below(flipped.size())] ^= static_cast<std::byte>(1U << random.below(8));
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
