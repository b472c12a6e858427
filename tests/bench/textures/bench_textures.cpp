// Stages on textures and regions, and exports of rooms: each beside its slow twin, or a quarter of the work.
#include "command_line.h"
#include "compose.h"
#include "enlarge.h"
#include "forked_case.h"
#include "plain_enlarge.h"
#include "report.h"
#include "room_parts.h"
#include "rooms.h"
#include "samples.h"
#include "usdz.h"

#include <fresco/page/page.h>
#include <fresco/texturing/exports.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <iterator>
#include <limits>

namespace
{

using namespace fresco;
using bench::Measure;

constexpr int repeats = 3;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

double cpu_ms(Measure& measure, const std::function<void()>& work)
{
    return 1e3 * measure.times(repeats, work).processor;
}

Value compared(const char* work, double fast_ms, const char* twin, double twin_ms, double apart)
{
    return Value::Map{{"work", work},       {"cpu_ms", fast_ms},          {"twin", twin},
                      {"twin_ms", twin_ms}, {"ratio", twin_ms / fast_ms}, {"apart", bench::figure(apart)}};
}

Value enlarging(Measure& measure)
{
    constexpr int size_px = 512;
    const Mesh mesh = two_chart_wall();
    const Raster8 picture = samples::detailed_picture(512, 384);
    const SourceMap map = samples::patched_map(mesh, 128, picture, 2, 8);
    Progress progress;
    enlarge::Enlarged fast;
    const double fast_ms = cpu_ms(measure, [&] { fast = enlarge::enlarged(map, picture, mesh, size_px, progress); });
    std::vector<std::pair<int, int>> places;
    samples::for_each_wall_texel(size_px,
                                 [&](int x, int y)
                                 {
                                     if (map.place(x * map.size_px() / size_px, y * map.size_px() / size_px))
                                         places.emplace_back(x, y);
                                 });
    std::vector<std::array<double, 3>> plain;
    const double plain_ms = cpu_ms(measure,
                                   [&]
                                   {
                                       plain.clear();
                                       for (const auto& [x, y] : places)
                                           plain.push_back(plain::enlarged(map, picture, size_px, x, y));
                                   });
    double apart = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
        for (int c = 0; c < 3; ++c)
            apart += std::abs(fast.picture.at(places[i].first, places[i].second, c) - plain[i][static_cast<std::size_t>(c)]);
    return compared("texture.enlarge", fast_ms, "each texel by its definition", plain_ms,
                    apart / (3 * static_cast<double>(places.size())));
}

Value composing(Measure& measure)
{
    constexpr int side = 1024;
    constexpr std::uint32_t regions = 16;
    Random random(1);
    const auto picture = [&]
    {
        KnownPicture result{RasterF(side, side, 3), Raster8(side, side, 1, 1)};
        for (float& value : result.rgb.values)
            value = static_cast<float>(random.uniform());
        return result;
    };
    const KnownPicture photo = picture();
    const KnownPicture painted = picture();
    std::vector<std::uint32_t> region_of_texel(photo.is_known.values.size());
    for (std::uint32_t& region : region_of_texel)
        region = static_cast<std::uint32_t>(regions * random.uniform());
    std::vector<RegionRule> rules(regions);
    for (std::size_t i = 1; i < regions; ++i)
        rules[i] = {&painted, static_cast<float>(i) / (regions - 1)};
    KnownPicture fast;
    const double fast_ms = cpu_ms(measure, [&] { fast = composed(photo, region_of_texel, rules); });
    RasterF plain;
    const double plain_ms = cpu_ms(measure,
                                   [&]
                                   {
                                       plain = photo.rgb;
                                       for (std::uint32_t region = 1; region < regions; ++region)
                                           for (std::size_t i = 0; i < plain.values.size(); ++i)
                                               if (region_of_texel[i / 3] == region)
                                                   plain.values[i] +=
                                                       rules[region].strength * (painted.rgb.values[i] - photo.rgb.values[i]);
                                   });
    double apart = 0;
    for (std::size_t i = 0; i < plain.values.size(); ++i)
        apart = std::max(apart, std::abs(double{plain.values[i]} - double{fast.rgb.values[i]}));
    return compared("texture.regions, 16 regions", fast_ms, "a pass for each region", plain_ms, apart);
}

KnownRoom room(float scale)
{
    KnownRoom result;
    result.noise_m = 0.003;
    result.shell({6 * scale, 4.5F * scale, 3 * scale});
    result.table(2, 2);
    return result;
}

Value dividing(Measure& measure)
{
    const KnownRoom large = room(2);
    const KnownRoom small = room(1);
    RoomParts parts;
    const double large_ms = cpu_ms(measure, [&] { parts = find_room_parts(large.mesh, 0.06, Progress()); });
    std::size_t wrong = 0;
    for (std::size_t face = 0; face < large.parts.size(); ++face)
        wrong += parts.of_face[face] == large.parts[face] ? 0 : 1;
    const double small_ms = cpu_ms(measure, [&] { parts = find_room_parts(small.mesh, 0.06, Progress()); });
    return compared("regions.planes, a quarter of the faces", small_ms, "all of them", large_ms,
                    static_cast<double>(wrong) / static_cast<double>(large.parts.size()));
}

Mesh with_texcoords()
{
    Mesh mesh = room(2).mesh;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            mesh.texcoords.push_back({mesh.positions[vertex].x / 12, mesh.positions[vertex].y / 12});
    return mesh;
}

Value paging(Measure& measure)
{
    const Mesh mesh = with_texcoords();
    std::string packed;
    const double packed_ms = cpu_ms(measure, [&] { packed = to_json(page::room(mesh, {})); });
    std::string plain;
    const double plain_ms = cpu_ms(measure,
                                   [&]
                                   {
                                       Value::List numbers;
                                       const auto rounded = [](float v) { return std::round(1e4 * double{v}) / 1e4; };
                                       for (const Vec3f& p : mesh.positions)
                                           numbers.insert(numbers.end(), {rounded(p.x), rounded(p.y), rounded(p.z)});
                                       for (const Vec2f& t : mesh.texcoords)
                                           numbers.insert(numbers.end(), {rounded(t.x), rounded(t.y)});
                                       for (const Triangle& triangle : mesh.triangles)
                                           for (const std::uint32_t vertex : triangle)
                                               numbers.emplace_back(std::size_t{vertex});
                                       plain = to_json(Value(std::move(numbers)));
                                   });
    Value row = compared("export.page, the mesh", packed_ms, "its numbers as JSON, to 0.1 mm", plain_ms, none);
    row.set("bytes_ratio", static_cast<double>(plain.size()) / static_cast<double>(packed.size()));
    return row;
}

Value packaging(Measure& measure)
{
    const texturing::WeldedMesh mesh = texturing::weld(with_texcoords());
    std::size_t bytes = 0;
    const double fast_ms =
        cpu_ms(measure,
               [&]
               {
                   bytes = 0;
                   write_usda(mesh, {.picture = "p.png", .lit = false}, [&](std::string_view piece) { bytes += piece.size(); });
               });
    std::string plain;
    const double plain_ms = cpu_ms(measure,
                                   [&]
                                   {
                                       plain.clear();
                                       for (const Vec3f& p : mesh.positions)
                                           fmt::format_to(std::back_inserter(plain), "({}, {}, {}), ", p.x, p.y, p.z);
                                       for (const Vec2f& t : mesh.texcoords)
                                           fmt::format_to(std::back_inserter(plain), "({}, {}), ", t.x, t.y);
                                       for (const std::uint32_t index : mesh.indices)
                                           fmt::format_to(std::back_inserter(plain), "{}, ", index);
                                   });
    Value row = compared("export.usdz, the layer", fast_ms, "its numbers by fmt", plain_ms, none);
    row.set("bytes_ratio", static_cast<double>(plain.size()) / static_cast<double>(bytes));
    return row;
}

}  // namespace

int main(int argc, char** argv)
{
    std::string json;
    CLI::App app{"Times stages on textures and regions, and exports of rooms, beside their slow twins"};
    app.add_option("--json", json, "File for the same figures as JSON");
    if (const auto code = bench::parse(app, argc, argv))
        return *code;
    bench::Table table("textures", "processor time on one thread, beside a slow twin or more work",
                       {{"work", "work"},
                        {"cpu_ms", "cpu ms"},
                        {"twin", "twin"},
                        {"twin_ms", "cpu ms"},
                        {"ratio", "times"},
                        {"bytes_ratio", "times the bytes"},
                        {"apart", "apart", 4}});
    for (const auto work : {enlarging, composing, dividing, paging, packaging})
        table.add(bench::run_case(work));
    bench::Report report("textures", Value::Map{});
    report.add(table);
    if (!json.empty())
        report.write(json);
    return 0;
}
