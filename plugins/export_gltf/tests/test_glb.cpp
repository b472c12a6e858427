#include "check_glb.h"
#include "exported_glb.h"
#include "glb.h"

#include <fresco/random.h>
#include <fresco/testing_scenes.h>

#include <cmath>

using namespace fresco;
using fresco::texturing::weld;
using fresco::texturing::WeldedMesh;

namespace
{
/// A bumpy floor of `side` x `side` squares, 7 m wide, somewhere in the world.
TexturedMesh floor_of(std::uint32_t side)
{
    TexturedMesh textured;
    Random random{3};
    textured.mesh = testing::rectangle({}, {1, 0, 0}, {0, 1, 0}, side, side);
    testing::set_texcoords(textured.mesh, [](Vec3f p) { return Vec2f{p.x, p.y}; });
    for (Vec3f& p : textured.mesh.positions)
        p = {7 * p.x - 20.03F, 3 + 0.4F * static_cast<float>(random.uniform()), 5 * p.y + 11.7F};
    textured.image = Image(Raster8(8, 8, 3, 77));
    return textured;
}

GlbModel model_of(const Exported& result)
{
    return read_glb(result.file, "room.glb");
}
}  // namespace

TEST_CASE("quantized positions are off by half a step at most, and some nearly are")
{
    const WeldedMesh mesh = weld(floor_of(40).mesh);
    const QuantizedMesh steps = quantized(mesh);
    // 7 m, rounded to floats far from the origin.
    CHECK(steps.step_m == Approx(7.0 / 65535).epsilon(1e-5));
    double worst = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        const Vec3d meant = vec_cast<double>(mesh.positions[i]);
        const auto& s = steps.positions[i];
        const Vec3d found =
            vec_cast<double>(steps.origin) + Vec3d{double(s[0]), double(s[1]), double(s[2])} * double{steps.step_m};
        for (const double error : {found.x - meant.x, found.y - meant.y, found.z - meant.z})
            worst = std::max(worst, std::abs(error));
        CHECK(s[3] == 0);
        const Vec2f uv = mesh.texcoords[i];
        CHECK(std::abs(steps.texcoords[i][0] / 65535.0 - double{uv.x}) <= 0.5 / 65535);
        CHECK(std::abs(steps.texcoords[i][1] / 65535.0 - (1 - double{uv.y})) <= 0.5 / 65535);
        for (const auto& [step, component] :
             {std::pair{steps.normals[i][0], mesh.normals[i].x}, {steps.normals[i][1], mesh.normals[i].y}})
            CHECK(std::abs(step / 127.0 - double{component}) <= 0.5 / 127);
    }
    CHECK(worst <= 0.5 * double{steps.step_m});
    CHECK(worst > 0.4 * double{steps.step_m});
}

TEST_CASE("a mesh without extent and one along one axis are quantized exactly")
{
    WeldedMesh point;
    point.positions = {{1, 2, 3}};
    point.normals = {{0, 0, 1}};
    point.texcoords = {{1, 0}};
    CHECK(quantized(point).step_m == 1);
    CHECK(quantized(point).positions[0] == std::array<std::uint16_t, 4>{0, 0, 0, 0});
    CHECK(quantized(point).normals[0] == std::array<std::int8_t, 4>{0, 0, 127, 0});
    CHECK(quantized(point).texcoords[0] == std::array<std::uint16_t, 2>{65535, 65535});
    WeldedMesh line = point;
    line.positions.push_back({1, 2, 3 + 65535.0F / 65536});
    line.normals.push_back({0, 0, -1});
    line.texcoords.push_back({0, 1});
    CHECK(quantized(line).step_m == 1.0F / 65536);
    CHECK(quantized(line).positions[1] == std::array<std::uint16_t, 4>{0, 0, 65535, 0});
    line.texcoords[1].x = 1.5F;
    CHECK_THROWS_WITH(quantized(line), Catch::Contains("texcoord is 1.5") && Catch::Contains("set quantize: false"));
}

TEST_CASE("a quantized file says so, keeps its promise, and stands upright")
{
    const TexturedMesh textured = floor_of(30);
    for (const char* material : {"unlit", "pbr"})
    {
        const Exported result = exported(Value::Map{{"quantize", true}, {"material", material}, {"up", "z"}}, textured);
        const Glb glb(result.file);
        CHECK(glb.json.at("extensionsRequired") == nlohmann::json{"KHR_mesh_quantization"});
        const auto& nodes = glb.json.at("nodes");
        CHECK(nodes.at(0).at("children") == nlohmann::json{1});
        CHECK(nodes.at(0).at("rotation").at(0).get<double>() == Approx(-std::sqrt(0.5)));
        CHECK(glb.view_of("POSITION").at("byteStride") == 8);
        const double half_step = 0.5 * nodes.at(1).at("scale").at(0).get<double>();
        const double error = result.report.at("position_error_m").as_double();
        CHECK(error > 0);
        CHECK(error <= half_step * 1.000001);
        CHECK(model_of(result).normals.empty() == (std::string(material) == "unlit"));
        const Exported plain = exported(Value::Map{{"material", material}}, textured);
        CHECK(result.file.size() < plain.file.size() * 4 / 5);
    }
}

TEST_CASE("indices take two bytes up to 65535 vertices, and four beyond")
{
    const auto type_of_index = [](std::uint32_t side)
    {
        const Exported result = exported(Value::Map{}, floor_of(side));
        const Glb glb(result.file);
        CHECK(model_of(result).indices.size() == std::size_t{6} * side * side);
        return glb.json.at("accessors").at(glb.primitive().at("indices").get<std::size_t>()).at("componentType").get<int>();
    };
    CHECK(type_of_index(254) == 5123);  // 255^2 = 65025 vertices
    CHECK(type_of_index(255) == 5125);  // 65536
}

TEST_CASE("compression keeps the surface, with and without quantization, and makes the file smaller")
{
    const TexturedMesh textured = floor_of(50);
    // The triangles, as points in any order.
    const auto surface = [](const GlbModel& model)
    {
        std::vector<std::array<double, 6>> corners;
        for (std::size_t i = 0; i < model.indices.size(); i += 3)
        {
            std::array<double, 6> sum{};
            for (std::size_t k = 0; k < 3; ++k)
            {
                const Vec3d p = model.positions[model.indices[i + k]];
                const Vec3d q = model.positions[model.indices[i + (k + 1) % 3]];
                const Vec3d turn = cross(p, q);
                for (const auto& [at, value] : {std::pair{0, p.x}, {1, p.y}, {2, p.z}, {3, turn.x}, {4, turn.y}, {5, turn.z}})
                    sum[static_cast<std::size_t>(at)] += value;
            }
            for (double& value : sum)
                value = std::round(value * 1e6) / 1e6;
            corners.push_back(sum);
        }
        std::ranges::sort(corners);
        return corners;
    };
    for (const bool quantize : {false, true})
    {
        const Exported plain = exported(Value::Map{{"quantize", quantize}, {"material", "pbr"}}, textured);
        const Exported small =
            exported(Value::Map{{"quantize", quantize}, {"material", "pbr"}, {"compression", "meshopt"}}, textured);
        CHECK(surface(model_of(small)) == surface(model_of(plain)));
        CHECK(small.file.size() < plain.file.size() * 4 / 5);
        const Glb glb(small.file);
        CHECK(glb.json.at("extensionsRequired").back() == "EXT_meshopt_compression");
        const auto& buffer = glb.json.at("buffers").at(1);
        CHECK_FALSE(buffer.contains("uri"));
        CHECK(buffer.at("extensions").at("EXT_meshopt_compression").at("fallback") == true);
        for (const auto& view : glb.json.at("bufferViews"))
            if (view.at("buffer") == 1)
                CHECK(view.at("byteOffset").get<std::size_t>() + view.at("byteLength").get<std::size_t>() <=
                      buffer.at("byteLength").get<std::size_t>());
    }
}
