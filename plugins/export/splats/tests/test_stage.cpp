#include "catch.h"
#include "painted_wall.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/testing.h>

#include <cmath>
#include <tuple>

using namespace fresco;
using namespace painted_wall;
using splats::SplatFormat;

namespace
{

struct Exported : testing::TemporaryFolder
{
    testing::TestRun run;
    std::shared_ptr<TexturedMesh> mesh = std::make_shared<TexturedMesh>(wall());

    std::vector<std::byte> output(const std::filesystem::path& splat, const std::string& name, Value options = Value::Map{})
    {
        options.set("file", splat.string());
        options.set("path", "deep/wall");
        options.set("stroke_cm", 100 * stroke_m);
        testing::run_stage(FRESCO_PLUGIN_FILE, "export.splats", options, {{"textured_mesh", mesh}}, path() / "out", run);
        CHECK(Files::load({path() / "out/files", {}})->names == std::vector<std::string>{name});
        return read_file(path() / "out/files" / name);
    }
    std::filesystem::path input(const splats::Splats& splats, SplatFormat format) const
    {
        write_file(path() / "in", splats::bytes_of(splats, format));
        return path() / "in";
    }
};

}  // namespace

TEST_CASE_METHOD(Exported, "A splat is painted in its own format, whatever its name is")
{
    const splats::Splats splats = covering(stroke_m / 6);
    for (const auto& [format, name] : {std::pair{SplatFormat::ply, "deep/wall.ply"},
                                       {SplatFormat::splat, "deep/wall.splat"},
                                       {SplatFormat::spz, "deep/wall.spz"}})
    {
        const auto file = splats::read_splats(input(splats, format));
        const auto found = splats::parse_splats(output(path() / "in", name), "out");
        CHECK(found.format == format);
        CHECK((found.splats.centers == file.splats.centers));
        CHECK((found.splats.rotations == file.splats.rotations));
        CHECK((found.splats.scales == file.splats.scales));
        CHECK((found.splats.opacities == file.splats.opacities));
        const Vec3f center = splats.centers[700];
        CHECK(length(vec_cast<double>(found.splats.colors[700]) - color(double{center.x}, double{center.y})) < 0.04);
        CHECK(run.reported.at("gaussians") == Value(splats.size()));
        CHECK(run.reported.at("unpainted") == Value(0));
        CHECK(run.files_read.back() == path() / "in");
    }
}

TEST_CASE_METHOD(Exported, "Another format, and Gaussians that are split")
{
    const splats::Splats splats = covering(0.05);
    const auto whole = input(splats, SplatFormat::ply);
    const auto found = splats::parse_splats(output(whole, "deep/wall.spz", Value::Map{{"format", "spz"}}), "out");
    CHECK(run.reported.at("split") == Value(splats.size()));
    CHECK(found.splats.size() > 4 * splats.size());
    CHECK(Value(found.splats.size()) == run.reported.at("gaussians"));
    const auto left = output(whole, "deep/wall.splat", Value::Map{{"format", "splat"}, {"densify", false}});
    CHECK(left.size() == 32 * splats.size());
    // SPZ is in meters.
    splats::Splats decimeters = splats;
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        decimeters.centers[i] = splats.centers[i] * 10;
        decimeters.scales[i] = splats.scales[i] * 10;
    }
    input(decimeters, SplatFormat::ply);
    const auto meters =
        splats::parse_splats(output(whole, "deep/wall.spz", Value::Map{{"format", "spz"}, {"unit_m", 0.1}}), "out");
    CHECK(meters.splats.centers == found.splats.centers);
    CHECK(meters.splats.scales == found.splats.scales);
    CHECK(meters.splats.colors == found.splats.colors);
}

TEST_CASE_METHOD(Exported, "What has +y up in its format is turned over in one that is shown with -y up, and back")
{
    splats::Splats splats = covering(0.05);
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const double turn = 0.1 * static_cast<double>(i);
        splats.rotations[i] = {static_cast<float>(std::cos(turn)), static_cast<float>(0.6 * std::sin(turn)),
                               static_cast<float>(0.8 * std::sin(turn)), 0};
    }
    for (const auto& [from, to, name] :
         {std::tuple{SplatFormat::spz, SplatFormat::ply, "ply"}, {SplatFormat::ply, SplatFormat::spz, "spz"}})
    {
        const auto file = splats::read_splats(input(splats, from)).splats;
        const auto found =
            splats::parse_splats(
                output(path() / "in", std::string("deep/wall.") + name, Value::Map{{"format", name}, {"densify", false}}), "out")
                .splats;
        REQUIRE(found.size() == file.size());
        for (std::size_t i = 0; i < file.size(); ++i)
        {
            const auto turned = [](auto v) { return decltype(v){v.x, -v.y, -v.z}; };
            CHECK(length(found.centers[i] - turned(file.centers[i])) < 1e-3F);
            for (std::size_t k = 0; k < 3; ++k)
                CHECK(dot(splats::axes_of(found, i)[k], turned(splats::axes_of(file, i)[k])) > 0.999);
        }
    }
}

TEST_CASE_METHOD(Exported, "What cannot be painted is refused")
{
    splats::Splats splats = covering(0.05);
    const auto whole = input(splats, SplatFormat::ply);
    CHECK_THROWS_WITH(output(whole, "", Value::Map{{"format", "spz"}, {"shine", "keep"}}),
                      Contains("shine: keep works only in the splat's own format, but PLY becomes SPZ"));
    CHECK_THROWS_WITH(output(whole, "", Value::Map{{"unit_m", 100.0}}), Contains("no Gaussian reaches the mesh"));
    write_file(path() / "in", std::string("no splat"));
    CHECK_THROWS_WITH(output(path() / "in", ""), Contains("isn't a file of Gaussian splats"));
}
