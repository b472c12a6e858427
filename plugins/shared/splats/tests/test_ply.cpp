#include "cut_bytes.h"
#include "splat_samples.h"

#include <fresco/error.h>

#include <limits>

using namespace fresco;
using namespace fresco::splats;

TEST_CASE("An INRIA PLY is read as it was trained")
{
    const SplatFile file = parse_splats(samples::ply(samples::four(), {.degree = 3, .behind = "behind"}), "x.ply");
    CHECK(file.format == SplatFormat::ply);
    samples::check_near(file.splats, samples::four(), 1e-5, 1e-5);
}

TEST_CASE("Quaternions are normalized, and Gaussians without one are not drawn")
{
    const SplatFile file = parse_splats(samples::ply(samples::four(), {.quaternion_length = 1.9F}), "x.ply");
    samples::check_near(file.splats, samples::four(), 1e-5, 1e-5);
    Splats none = samples::four();
    none.rotations[2] = {0, 0, 0, 0};
    const SplatFile counted = parse_splats(samples::ply(none), "x.ply");
    CHECK(counted.splats.opacities[2] == 0);
    CHECK(counted.splats.rotations[2] == std::array<float, 4>{1, 0, 0, 0});
    CHECK(counted.splats.opacities[1] == Approx(0.2));
}

TEST_CASE("A damaged PLY is refused, and the error names the place")
{
    const auto whole = samples::ply(samples::four(), {.degree = 1});
    check_cuts_are_refused(whole, "x.ply", [](const auto& bytes) { return parse_splats(bytes, "x.ply"); });
    const auto changed = [&](const std::string& from, const std::string& to)
    {
        std::string text(reinterpret_cast<const char*>(whole.data()), whole.size());
        text.replace(text.find(from), from.size(), to);
        return parse_splats(samples::bytes_of(text), "x.ply");
    };
    CHECK_THROWS_WITH(changed("vertex 4", "vertex 999999999999"),
                      Contains("x.ply:4: 999999999999 elements 'vertex'") && Contains("do not fit"));
    CHECK_THROWS_WITH(changed("vertex 4", "vertex 0"), Contains("has no vertices"));
    CHECK_THROWS_WITH(changed("vertex 4", "vertex -4"), Contains("x.ply:4: expected the number of 'vertex' elements"));
    CHECK_THROWS_WITH(changed("binary_little_endian", "binary_big_endian"),
                      Contains("expected \"format binary_little_endian 1.0\""));
    CHECK_THROWS_WITH(changed("opacity", "opacitee"), Contains("lacks \"property float opacity\""));
    CHECK_THROWS_WITH(changed("f_rest_8", "f_west_8"), Contains("8 properties f_rest_*"));
    Splats bad = samples::four();
    bad.centers[3].y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(parse_splats(samples::ply(bad), "x.ply"), Contains("Gaussian 3 has a number that is not finite"));
    bad = samples::four();
    bad.scales[1].z = std::numeric_limits<float>::infinity();
    CHECK_THROWS_WITH(parse_splats(samples::ply(bad), "x.ply"), Contains("Gaussian 1 has"));
}

TEST_CASE("A header cannot claim rows that are not there")
{
    const auto refused = [](const std::string& elements)
    {
        const std::string file = "ply\nformat binary_little_endian 1.0\n" + elements + "end_header\n";
        return testing::error_of([&] { parse_splats(std::as_bytes(std::span(file)), "x.ply"); });
    };
    std::string vertex = "element vertex 4000000000\n";
    for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                             "rot_1", "rot_2", "rot_3"})
        vertex += std::string("property float ") + name + "\n";
    CHECK_THAT(refused(vertex), Contains("4000000000 elements 'vertex'") && Contains("do not fit into the 0 bytes"));
    CHECK_THAT(refused("element face 0\nproperty list uchar int v\n" + vertex.substr(0, vertex.find("4000")) + "0\n"),
               Contains("\"face\" has lists"));
    CHECK_THAT(refused("element none 1\n" + vertex), Contains("element 'none' has no properties"));
    CHECK_THAT(refused("element vertex 99999999999999999999\n"), Contains("expected the number of 'vertex' elements"));
}
