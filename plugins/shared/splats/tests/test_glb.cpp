#include "cut_bytes.h"
#include "shared_data.h"
#include "splat_samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>

using namespace fresco;
using namespace fresco::splats;

namespace
{

const std::string ellipse = R"("kernel":"ellipse","colorSpace":"srgb_rec709_display")";

/// One Gaussian, turned by 90 degrees about x, on a node that is moved, turned by 90 degrees about z and doubled.
std::string glb(const std::string& form = ellipse, std::array<float, 3> scale = {0.1F, 0.2F, 0.01F})
{
    std::string binary;
    const float half = std::sqrt(0.5F);
    for (const float each : {1.F, 2.F, 3.F, half, 0.F, 0.F, half, scale[0], scale[1], scale[2], 0.25F, 0.5F, -0.5F, 1.F})
        binary += samples::raw(each);
    std::string json =
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_gaussian_splatting"],"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"translation":[10,0,0],"rotation":[0,0,0.70710678,0.70710678],"scale":[2,2,2]}],
        "meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0,"KHR_gaussian_splatting:ROTATION":1,
        "KHR_gaussian_splatting:SCALE":2,"KHR_gaussian_splatting:OPACITY":3,"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0":4},
        "extensions":{"KHR_gaussian_splatting":{)" +
        form + R"(}}}]}],"buffers":[{"byteLength":56}],"bufferViews":[{"buffer":0,"byteLength":56}],"accessors":[
        {"bufferView":0,"byteOffset":0,"count":1,"componentType":5126,"type":"VEC3"},
        {"bufferView":0,"byteOffset":12,"count":1,"componentType":5126,"type":"VEC4"},
        {"bufferView":0,"byteOffset":28,"count":1,"componentType":5126,"type":"VEC3"},
        {"bufferView":0,"byteOffset":40,"count":1,"componentType":5126,"type":"SCALAR"},
        {"bufferView":0,"byteOffset":44,"count":1,"componentType":5126,"type":"VEC3"}]})";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto size = [](std::size_t bytes) { return samples::raw(static_cast<std::uint32_t>(bytes)); };
    return "glTF" + size(2) + size(28 + json.size() + binary.size()) + size(json.size()) + "JSON" + json + size(binary.size()) +
           std::string("BIN\0", 4) + binary;
}

SplatFile parsed(const std::string& file)
{
    return parse_splats(std::as_bytes(std::span(file)), "x.glb");
}

}  // namespace

TEST_CASE("A GLB's Gaussians lie where its nodes place them, and what is not read is refused with a way out")
{
    const auto refused = [](const std::string& file) { return testing::error_of([&] { parsed(file); }); };
    if (refused("glTF").find("built without") != std::string::npos)
        return;
    Splats expected;
    expected.centers = {{10 - 4, 2, 6}};
    expected.rotations = {{0.5F, 0.5F, 0.5F, 0.5F}};  // About x, then about z.
    expected.scales = {{0.2F, 0.4F, 0.02F}};
    expected.opacities = {0.25F};
    expected.colors = {{0.5F + 0.5F * 0.28209479F, 0.5F - 0.5F * 0.28209479F, 0.5F + 0.28209479F}};
    CHECK(parsed(glb()).format == SplatFormat::glb);
    samples::check_near(parsed(glb()).splats, expected, 1e-5, 1e-5);
    // As the drafts had it.
    samples::check_near(parsed(glb(ellipse, {std::log(0.1F), std::log(0.2F), std::log(0.01F)})).splats, expected, 1e-5, 1e-5);
    expected.colors = {{0.8216F, 0.6334F, 0.8973F}};
    samples::check_near(parsed(glb(R"("kernel":"ellipse","colorSpace":"lin_rec709_display")")).splats, expected, 1e-5, 1e-3);

    CHECK_THAT(refused(glb(R"("kernel":"cube")")), Contains("x.glb: its splats are compressed or of another kernel"));
    CHECK_THAT(refused(glb(ellipse + R"(,"extensions":{"KHR_gaussian_splatting_compression_spz_2":{"bufferView":0}})")),
               Contains("splat-transform IN.glb OUT.ply"));
    const auto changed = [&](const std::string& from, const std::string& to)
    {
        std::string file = glb();
        return refused(file.replace(file.find(from), from.size(), to));
    };
    CHECK_THAT(changed("[2,2,2]", "[2,2,1]"), Contains("mirrored or stretched"));
    CHECK_THAT(changed(":OPACITY", ":OPACITE"), Contains("lacks the attribute KHR_gaussian_splatting:OPACITY"));
    CHECK_THAT(changed("\"extensions\"", "\"extensi0ns\""), Contains("models are read by scan.mesh"));
    const std::string file = glb();
    check_cuts_are_refused(std::as_bytes(std::span(file)), "x.glb",
                           [](const auto& bytes) { return parse_splats(bytes, "x.glb"); });
    const auto path = shared_data("splats/fixtures/bevy_khr_conformance_matrix.glb", "the reader of GLB");
    if (!path.empty())
        CHECK(read_splats(path).splats.size() == 15);
}
