#include "cut_bytes.h"
#include "shared_data.h"
#include "splat_samples.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cstring>

using namespace fresco;
using namespace fresco::splats;

namespace
{

const std::array written{SplatFormat::ply, SplatFormat::splat, SplatFormat::spz};

/// Half a step of the coarsest numbers of a format, and of its colors.
std::pair<double, double> steps(SplatFormat format)
{
    return format == SplatFormat::ply     ? std::pair{1e-5, 1e-5}
           : format == SplatFormat::splat ? std::pair{0.02, 0.004}
                                          : std::pair{0.025, 0.01};
}

/// Colors that every format holds.
Splats plain()
{
    Splats splats = samples::four();
    splats.colors = {{0.25F, 0.5F, 0.75F}, {0.9F, 0.5F, 0}, {0.16F, 0, 1}, {1, 1, 1}};
    return splats;
}

/// Each Gaussian as it is but for its color.
PaintedSplats recolored(const Splats& splats)
{
    PaintedSplats painted;
    for (std::uint32_t i = 0; i < splats.size(); ++i)
        painted.parts.push_back({i, false, false, {}, {}, 0, {0.2F * static_cast<float>(i), 0.5F, 0.1F}});
    return painted;
}

template <class Bytes>
void overwrite(Bytes& bytes, std::size_t at, std::uint32_t number)
{
    std::memcpy(bytes.data() + at, &number, sizeof number);
}

}  // namespace

TEST_CASE("What is written in a format reads back")
{
    for (const SplatFormat format : written)
    {
        CAPTURE(std::string(name_of(format)));
        const auto [tolerance, color_tolerance] = steps(format);
        const SplatFile file = parse_splats(bytes_of(plain(), format), "x");
        CHECK(file.format == format);
        samples::check_near(file.splats, plain(), tolerance, color_tolerance);
    }
    Splats far = plain();
    far.centers[0] = {70000, -3, 5};
    const SplatFile file = parse_splats(bytes_of(far, SplatFormat::spz), "x");
    CHECK(length(file.splats.centers[0] - far.centers[0]) < 0.01);
}

TEST_CASE("Painting changes only colors in the file's own format")
{
    const testing::TemporaryFolder folder;
    for (const SplatFormat format : written)
    {
        CAPTURE(std::string(name_of(format)));
        const auto path = folder.path() / "x";
        auto bytes = bytes_of(plain(), format);
        write_file(path, bytes);
        const SplatFile file = read_splats(path);
        PaintedSplats painted = recolored(file.splats);
        painted.parts[3].keeps_color = true;
        const SplatFile again = parse_splats(painted_bytes(path, file, painted, format, false), "again");
        CHECK(again.splats.centers == file.splats.centers);
        CHECK(again.splats.rotations == file.splats.rotations);
        CHECK(again.splats.scales == file.splats.scales);
        CHECK(again.splats.opacities == file.splats.opacities);
        CHECK(again.splats.colors[3] == file.splats.colors[3]);
        CHECK(length(again.splats.colors[2] - Vec3f{0.4F, 0.5F, 0.1F}) < 0.01);
        // The colors that it has leave it as it is.
        for (std::size_t i = 0; i < painted.parts.size(); ++i)
            painted.parts[i].color = file.splats.colors[i];
        CHECK(painted_bytes(path, file, painted, format, false) == bytes);
    }
}

TEST_CASE("Parts of Gaussians are written in every format, with the rotation of theirs")
{
    const testing::TemporaryFolder folder;
    for (const SplatFormat from : written)
        for (const SplatFormat to : written)
        {
            CAPTURE(std::string(name_of(from)), std::string(name_of(to)));
            const auto path = folder.path() / "x";
            write_file(path, bytes_of(plain(), from));
            const SplatFile file = read_splats(path);
            PaintedSplats painted = recolored(file.splats);
            painted.parts.push_back({1, true, false, {2, 3, 4}, {0.05F, 0.05F, 0.01F}, 0.75F, {0.5F, 0.25F, 1}});
            const SplatFile again = parse_splats(painted_bytes(path, file, painted, to, false), "again");
            CHECK(again.format == to);
            Splats expected = plain();
            for (std::size_t i = 0; i < 4; ++i)
                expected.colors[i] = painted.parts[i].color;
            expected.centers.push_back({2, 3, 4});
            expected.rotations.push_back(expected.rotations[1]);
            expected.scales.push_back({0.05F, 0.05F, 0.01F});
            expected.opacities.push_back(0.75F);
            expected.colors.push_back({0.5F, 0.25F, 1});
            const double tolerance = std::max({steps(from).first, steps(to).first}) * 1.5;
            samples::check_near(again.splats, expected, tolerance, steps(to).second);
        }
}

TEST_CASE("A PLY keeps what fresco does not know; its harmonics go or stay")
{
    const testing::TemporaryFolder folder;
    const auto path = folder.path() / "x.ply";
    const auto bytes = samples::ply(samples::four(), {.degree = 2, .behind = "behind"});
    write_file(path, bytes);
    const SplatFile file = read_splats(path);
    PaintedSplats same = recolored(file.splats);
    for (auto& part : same.parts)
        part.keeps_color = true;
    CHECK(painted_bytes(path, file, same, SplatFormat::ply, true) == bytes);
    CHECK(painted_bytes(path, file, same, SplatFormat::ply, false) ==
          samples::ply(samples::four(), {.degree = 0, .behind = "behind"}));
    write_file(path, bytes_of(Splats{{{}}, {{1, 0, 0, 0}}, {{1, 1, 1}}, {0.5F}, {{}}}, SplatFormat::ply));
    CHECK_THROWS_WITH(painted_bytes(path, file, same, SplatFormat::ply, true), Contains("has changed"));
}

TEST_CASE("Damaged files are refused in every format")
{
    const auto splat = bytes_of(plain(), SplatFormat::splat);
    auto bad = splat;
    overwrite(bad, 32 + 12, 0xbf800000U);  // A scale of -1.
    CHECK_THROWS_WITH(parse_splats(bad, "x.splat"), Contains("x.splat: isn't a file of Gaussian splats"));
    bad = splat;
    overwrite(bad, 4, 0x7fc00000U);
    CHECK_THROWS_WITH(parse_splats(bad, "x.splat"), Contains("isn't a file of"));
    CHECK_THROWS_WITH(parse_splats(std::span(splat).first(100), "x.splat"), Contains("is cut short"));
    bad = splat;
    overwrite(bad, 28, 0x80808080U);
    CHECK(parse_splats(bad, "x.splat").splats.opacities[0] == 0);

    const auto spz = bytes_of(plain(), SplatFormat::spz);
    check_cuts_are_refused(std::span(spz).first(spz.size() - 8), "x.spz",  // The checksum isn't needed.
                           [](const auto& bytes) { return parse_splats(bytes, "x.spz"); });
    // Plain ones are read, too, as the fixtures have them.
    std::vector<std::byte> plain_spz(16 + 4 * (9 + 1 + 3 + 3 + 3));
    std::memcpy(plain_spz.data(), "NGSP\2\0\0\0\4\0\0\0\0\14", 14);
    CHECK(parse_splats(plain_spz, "x.spz").splats.size() == 4);
    const auto changed = [&](std::size_t at, std::uint32_t number)
    {
        auto bytes = plain_spz;
        overwrite(bytes, at, number);
        return parse_splats(bytes, "x.spz");
    };
    CHECK_THROWS_WITH(changed(4, 1), Contains("is SPZ 1; fresco reads 2, 3 and 4; \"spz_to_ply"));
    CHECK_THROWS_WITH(changed(4, 5), Contains("is SPZ 5") && Contains("spz_to_ply"));
    CHECK_THROWS_WITH(changed(8, 0xffffffffU), Contains("cannot hold the 4294967295 Gaussians"));
    CHECK_THROWS_WITH(changed(8, 0), Contains("cannot hold the 0 Gaussians"));
    CHECK_THROWS_WITH(changed(8, 5), Contains("its 5 Gaussians end"));
    CHECK_THROWS_WITH(changed(12, 9), Contains("harmonics of degree 9"));
    CHECK_THROWS_WITH(parse_splats(samples::bytes_of("\x1f\x8b\x08" + std::string(40, '\0')), "x.gz"), Contains("x.gz"));
    CHECK_THROWS_WITH(parse_splats({}, "x"), Contains("isn't a file of"));
}

TEST_CASE("Formats that are not read are refused by name, with the way out")
{
    const testing::TemporaryFolder folder;
    const auto meta = [&](const std::string& text)
    {
        write_file(folder.path() / "meta.json", text);
        return testing::error_of([&] { read_splats(folder.path()); });
    };
    CHECK_THAT(meta(R"({"means": {}})"), Contains("is SOG 1; \"splat-transform"));
    CHECK_THAT(meta(R"({"lodLevels": 3})"), Contains("is a streamed SOG; \"splat-transform"));
    CHECK_THAT(meta(R"({"version": 3})"), Contains("expected 2; \"splat-transform"));
    std::filesystem::create_directory(folder.path() / "lod");
    write_file(folder.path() / "lod/lod-meta.json", std::string(R"({"lodLevels": 3})"));
    CHECK_THROWS_WITH(read_splats(folder.path() / "lod"), Contains("is a streamed SOG; \"splat-transform"));
    write_file(folder.path() / "a.gltf", std::string(R"({"asset": {}})"));
    CHECK_THROWS_WITH(read_splats(folder.path() / "a.gltf"), Contains("export it as .glb"));
    CHECK_THAT(meta(R"({"version": 2, "count": 999999})"), Contains("bytes cannot hold 999999 Gaussians"));
    CHECK_THROWS_AS(read_splats(folder.path() / "none.ply"), MissingInput);
    const auto ksplat = shared_data("splats/fixtures/splattransform_minimal.ksplat", "KSPLAT");
    if (!ksplat.empty())
        CHECK_THAT(testing::error_of([&] { read_splats(ksplat); }),
                   Contains("KSPLAT is not supported") && Contains("splat-transform"));
}

TEST_CASE("Four Gaussians of splat-transform are the same in all formats")
{
    const auto folder = shared_data("splats/fixtures", "the readers of SPLAT and SPZ");
    if (folder.empty())
        return;
    // As the uncompressed file has them, by hand.
    Splats truth;
    truth.centers = {{-1, 0, -1}, {0, 0, -1}, {-1, 0, 0}, {0, 0, 0}};
    truth.rotations.assign(4, {1, 0, 0, 0});
    truth.scales.assign(4, Vec3f{1, 1, 1} * std::exp(123 / 16.0F - 10));
    truth.opacities.assign(4, 230 / 255.0F);
    const auto color = [](int r, int g)
    {
        const auto channel = [](int byte) { return (static_cast<float>(byte) / 255 - 0.5F) / 0.15F * 0.28209479F + 0.5F; };
        return Vec3f{channel(r), channel(g), channel(0x80)};
    };
    truth.colors = {color(0x55, 0x55), color(0xaa, 0x55), color(0x55, 0xaa), color(0xaa, 0xaa)};
    for (const char* name : {"minimal-raw.spz", "minimal-v2.spz"})
    {
        CAPTURE(name);
        const SplatFile file = read_splats(folder / ("splattransform_" + std::string(name)));
        CHECK(file.format == SplatFormat::spz);
        samples::check_near(file.splats, truth, 1e-4, 1e-5);
    }
    // The colors are one third and two thirds in those that were made from a PLY …
    truth.colors = {{1 / 3.F, 1 / 3.F, 0.5F}, {2 / 3.F, 1 / 3.F, 0.5F}, {1 / 3.F, 2 / 3.F, 0.5F}, {2 / 3.F, 2 / 3.F, 0.5F}};
    truth.rotations.assign(4, {0, 0, 0, 1});
    const SplatFile splat = read_splats(folder / "splattransform_minimal.splat");
    CHECK(splat.format == SplatFormat::splat);
    samples::check_near(splat.splats, truth, 0.011, 0.004);
    // … and turned about x in SPZ 3 and 4.
    truth.rotations.assign(4, {1, 0, 0, 0});
    for (Vec3f& center : truth.centers)
        center.z = -center.z;
    for (const char* name : {"minimal-v3.spz", "minimal-v4.spz"})
    {
        CAPTURE(name);
        samples::check_near(read_splats(folder / ("splattransform_" + std::string(name))).splats, truth, 0.011, 0.01);
    }
}

TEST_CASE("SPZ 4 stays SPZ 4, with all that it has")
{
    const auto path = shared_data("splats/fixtures/splattransform_minimal-v4.spz", "the writer of SPZ 4");
    if (path.empty())
        return;
    const SplatFile file = read_splats(path);
    PaintedSplats painted = recolored(file.splats);
    for (auto& part : painted.parts)
        part.keeps_color = true;
    const auto same = painted_bytes(path, file, painted, SplatFormat::spz, true);
    CHECK(std::memcmp(same.data(), "NGSP\4", 5) == 0);
    CHECK(parse_splats(same, "x").splats.rotations == file.splats.rotations);
    CHECK(parse_splats(same, "x").splats.colors == file.splats.colors);
    check_cuts_are_refused(same, "x.spz", [](const auto& bytes) { return parse_splats(bytes, "x.spz"); });
}

TEST_CASE("A toy house in meters")
{
    const auto path = shared_data("splats/pdal_fourth_st.spz", "the reader of SPZ 2");
    if (path.empty())
        return;
    const SplatFile file = read_splats(path);
    CHECK(file.splats.size() == 131199);
    std::vector<float> x;
    for (const Vec3f center : file.splats.centers)
        x.push_back(center.x);
    std::ranges::sort(x);
    CHECK(x[x.size() * 95 / 100] - x[x.size() * 5 / 100] == Approx(0.25).margin(0.15));
}

TEST_CASE("The angel is the same in a compressed PLY and, half a turn about z later, in a SOG")
{
    const auto ply = shared_data("splats/webcomp_angel.compressed.ply", "the angel");
    const auto sog = shared_data("splats/webcomp_angel.sog", "the angel");
    if (ply.empty() || sog.empty())
        return;
    const Splats a = read_splats(ply).splats;
    const SplatFile file = read_splats(sog);
    CHECK(file.format == SplatFormat::sog);
    const Splats& b = file.splats;
    REQUIRE(b.size() == 71359);
    // SOG sorts its Gaussians: the nearest along x within the tolerance.
    std::vector<std::pair<float, std::size_t>> by_x;
    for (std::size_t i = 0; i < a.size(); ++i)
        by_x.emplace_back(a.centers[i].x, i);
    std::ranges::sort(by_x);
    std::size_t near = 0;
    std::size_t alike = 0;
    for (std::size_t i = 0; i < b.size(); ++i)
    {
        constexpr float tolerance = 0.001F;
        const Vec3f center{-b.centers[i].x, -b.centers[i].y, b.centers[i].z};
        float best = tolerance;
        std::size_t found = a.size();
        for (auto at = std::ranges::lower_bound(by_x, std::pair{center.x - tolerance, std::size_t{0}});
             at != by_x.end() && at->first <= center.x + tolerance; ++at)
            if (const float distance = length(a.centers[at->second] - center); distance < best)
            {
                best = distance;
                found = at->second;
            }
        near += found < a.size() ? 1 : 0;
        alike += found < a.size() && length(a.colors[found] - b.colors[i]) < 0.05F &&
                         std::abs(a.opacities[found] - b.opacities[i]) < 0.02F
                     ? 1
                     : 0;
    }
    CHECK(static_cast<double>(near) / static_cast<double>(b.size()) > 0.985);
    CHECK(static_cast<double>(alike) / static_cast<double>(b.size()) > 0.8);
}

TEST_CASE("A SPLAT file may begin with any byte, and SPZ refuses places that its steps would lose")
{
    const testing::TemporaryFolder folder;
    Splats some = samples::four();
    // As JSON, gzip and zip files begin.
    for (const std::uint32_t start : {0x3f80007bU, 0x3f808b1fU, 0x3f804b50U})
    {
        std::memcpy(&some.centers[0].x, &start, sizeof start);
        write_file(folder.path() / "a.splat", bytes_of(some, SplatFormat::splat));
        CHECK(read_splats(folder.path() / "a.splat").splats.size() == 4);
    }
    for (Vec3f& center : some.centers)
        center.y += 5'400'000;
    CHECK_THROWS_WITH(bytes_of(some, SplatFormat::spz), Contains("set format: ply"));
}
