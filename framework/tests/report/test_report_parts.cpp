#include "stored_png.h"
#include "report/report_charts.h"
#include "report/report_figures.h"
#include "report/report_graph.h"
#include "report/report_media.h"
#include "report/report_room.h"
#include "worker/metric_curves.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>

using namespace fresco;
using namespace fresco::host;

TEST_CASE("figures are told in words, with what was before beside what is now")
{
    const Value report = Value::Map{{"faces_before", 813175},
                                    {"area_m2_before", 2.0},
                                    {"faces_after", 499995},
                                    {"area_m2_after", 8.0},
                                    {"used_share", 0.3188},
                                    {"texels_per_cm", 1.09},
                                    {"largest_angle_deg", 70},
                                    {"bytes", 9071468},
                                    {"list", Value::List{1, 2}},
                                    {"losses", Value::Map{{"style", 1.5}, {"content", Value()}}},
                                    {"below_after", 3},
                                    {"judged_frames", Value::Map{{"least", 150}}},
                                    {"table", Value::Map{{"columns", Value::List{"a"}}}}};
    std::vector<std::string> lines;
    for (const ReportFigure& figure : report_figures(report))
        lines.push_back(figure.label + "|" + figure.before + "|" + figure.value + "|" + figure.change);
    CHECK(lines == std::vector<std::string>{"faces|813\u202f175|499\u202f995|−38.5 %", "area|2 m²|8 m²|×4", "used||31.88 %|",
                                            "texels per cm||1.09|", "largest angle||70 °|", "bytes||9.1 MB|",
                                            "losses style||1.5|", "losses content||not finite|", "below after||3|"});
    CHECK(report_figures(Value()).empty());
    CHECK(figure_text(1234) == "1234");
    CHECK(figure_text(-12345.0) == "−12\u202f345");
    CHECK(figure_text(std::numeric_limits<std::int64_t>::min()).ends_with("808"));
    CHECK(figure_text(0.000123456) == "0.0001235");
    CHECK(bytes_text(999) == "999 bytes");
    CHECK(bytes_text(12'345'678) == "12.3 MB");
}

TEST_CASE("a stage's table is shown row by row")
{
    const auto table = [](const char* text) { return report_table(Value::Map{{"table", parse_json(text)}}); };
    CHECK(table(R"({"columns": ["figure", "mean"], "rows": [["a < b", 0.25], ["c", null]]})") ==
          "<div class=\"scroll\"><table><tr><th>figure</th><th>mean</th></tr>\n"
          "<tr><td>a &lt; b</td><td class=\"number\">0.25</td></tr>\n<tr><td>c</td><td></td></tr>\n</table></div>\n");
    for (const char* none : {"7", "{}", R"({"columns": ["a"], "rows": []})", R"({"columns": 1, "rows": [[2]]})"})
        CHECK(table(none).empty());
    CHECK(report_table(Value()).empty());
}

TEST_CASE("stages are drawn behind what they wait for, and no two in one place")
{
    const auto stage = [](const std::string& name, const std::vector<std::string>& from)
    {
        ReportStage result;
        result.name = name;
        result.state = "ran";
        for (const auto& producer : from)
            result.inputs.push_back({"port", "mesh", producer, "out", ""});
        result.inputs.push_back({"port", "image", "", "", "picture.png"});
        return result;
    };
    // scan feeds all; views waits for the longest way.
    const std::vector<ReportStage> stages{stage("scan", {}), stage("mesh", {"scan"}), stage("atlas", {"mesh", "scan"}),
                                          stage("views", {"atlas", "scan", "scan"})};
    const GraphDrawing drawing = draw_graph(stages);
    CHECK(drawing.layers == 4);
    for (int i = 0; i < 4; ++i)
        CHECK(drawing.boxes[static_cast<std::size_t>(i)].layer == i);
    REQUIRE(drawing.ways.size() == 5);
    // scan → atlas passes one layer, scan → views two.
    CHECK(drawing.boxes.size() == 4 + 1 + 2);
    std::set<std::pair<int, int>> places;
    for (const GraphBox& box : drawing.boxes)
        CHECK(places.emplace(box.layer, box.row).second);
    for (const auto& way : drawing.ways)
        for (std::size_t i = 0; i + 1 < way.size(); ++i)
            CHECK(drawing.boxes[static_cast<std::size_t>(way[i])].layer + 1 ==
                  drawing.boxes[static_cast<std::size_t>(way[i + 1])].layer);
    const std::string svg = graph_svg(stages);
    CHECK(svg.find("href=\"#stage-3\"") != std::string::npos);
    CHECK(graph_svg({}).find("<svg") == 0);
}

TEST_CASE("curves are kept within bounds, go back with their stage and survive a killed run")
{
    const auto loss = [](double value) { return Value(Value::Map{{"loss", value}}); };
    MetricCurves curves;
    CHECK_FALSE(curves.add(0, Value::Map{}));
    CHECK(curves.to_value("steps").is_null());
    for (int step = 1; step <= 10'000; ++step)
        curves.add(step, loss(step));
    CHECK(curves.points().size() <= MetricCurves::most_points);
    CHECK(curves.points().size() > MetricCurves::most_points / 3);
    CHECK(curves.points().front().done == 1);
    CHECK(curves.points().back().done > 9900);
    const double step = curves.points()[1].done - curves.points()[0].done;
    for (std::size_t i = 1; i < curves.points().size(); ++i)
        CHECK(curves.points()[i].done - curves.points()[i - 1].done == step);
    MetricCurves back;
    for (const int done : {1, 2, 3, 4, 2})
        back.add(done, loss(done * 10));
    CHECK(back.to_value("steps").at("done") == Value::List{1.0, 2.0});

    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "curves";
    std::ofstream(file) << MetricCurves::line(1, loss(4)) << MetricCurves::line(2, loss(3))
                        << MetricCurves::line(3, Value::Map{{"loss", Value()}, {"other", 7}}) << R"({"done":4,"me)";
    MetricCurves taken;
    taken.load(file);
    taken.load(folder.path() / "nothing");
    CHECK(taken.to_value("steps") ==
          parse_json(R"({"unit":"steps","done":[1.0,2.0,3.0],"metrics":{"loss":[4.0,3.0,null],"other":[null,null,7]}})"));
}

TEST_CASE("charts are drawn from what stages report, and from nothing else")
{
    CHECK(round_ticks(0, 10, 5) == std::vector<double>{0, 2, 4, 6, 8, 10});
    CHECK(round_ticks(-0.3, 0.31, 3).size() == 3);
    CHECK(round_ticks(4, 4, 3) == std::vector<double>{4});
    // The whole numbers between are no doubles.
    CHECK(round_ticks(1e17, 1e17 + 16, 4).size() <= 5);
    const Value curves = parse_json(R"({"unit":"steps","done":[1,2,3],"metrics":{"a_loss":[100,10,1],"once":[1,null,null]}})");
    const std::string charts = curve_charts(curves);
    CHECK(charts.find("a loss over steps: first 100, last 1, least 1") != std::string::npos);
    CHECK(charts.find("once") == std::string::npos);
    // Logarithmic: the middle point is half way down. 10 px above and 24 below are not the chart's.
    CHECK(charts.find(" 88.0L") != std::string::npos);
    CHECK(curve_charts(Value()).empty());
    CHECK(curve_charts(Value::Map{{"done", 3}}).empty());

    const std::string frames = frames_chart(parse_json(
        R"({"measure":"sharpness","least":150,"names":["s/a","s/b","s/<c>"],"values":[300,100,200],"kept":[true,false,false]})"));
    CHECK(frames.find("class=\"kept\" x=\"0.00\"") != std::string::npos);
    CHECK(frames.find("class=\"below\"") != std::string::npos);
    CHECK(frames.find("class=\"dropped\"") != std::string::npos);
    CHECK(frames.find("<c>") == std::string::npos);
    CHECK(frames_chart(parse_json(R"({"measure":"x","names":["a"],"values":[],"kept":[]})")).empty());
    CHECK(frames_chart(Value(3)).empty());
    Value::List names;
    Value::List values;
    Value::List kept;
    for (int i = 0; i < 5000; ++i)
    {
        names.emplace_back("frame");
        values.emplace_back(i);
        kept.emplace_back(true);
    }
    const std::string many = frames_chart(Value::Map{{"measure", "x"}, {"names", names}, {"values", values}, {"kept", kept}});
    CHECK(many.size() < 150'000);
    CHECK(many.find("5000 kept") != std::string::npos);
}

TEST_CASE("a packed room has the mesh's corners to half a step")
{
    Mesh mesh;
    mesh.positions = {{-1, 0, 2}, {3, 0.25F, 2}, {3, 1, 2}, {-1, 1, 2}, {99, 99, 99}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    // The faces share an edge; vertex 0 has two texcoords.
    mesh.texcoords = {{0.1F, 0.2F}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    const PackedRoom room = pack_room(mesh);
    CHECK(room.vertices == 5);
    CHECK(room.triangles == 2);
    CHECK(room.low == std::array<double, 3>{-1, 0, 2});
    CHECK(room.extent == std::array<double, 3>{4, 1, 0});  // The vertex of no face does not count.
    REQUIRE(room.bytes.size() == 12 * room.vertices + 12 * room.triangles);
    std::vector<std::uint16_t> values(6 * room.vertices);
    std::vector<std::uint32_t> corners(3 * room.triangles);
    std::memcpy(values.data(), room.bytes.data(), 12 * room.vertices);
    std::memcpy(corners.data(), room.bytes.data() + 12 * room.vertices, 12 * room.triangles);
    for (std::size_t corner = 0; corner < 6; ++corner)
    {
        REQUIRE(corners[corner] < room.vertices);
        const std::uint16_t* packed = &values[6 * corners[corner]];
        const Vec3f position = mesh.positions[mesh.triangles[corner / 3][corner % 3]];
        const Vec2f uv = mesh.texcoords[corner];
        CHECK(std::abs(room.low[0] + packed[0] * room.extent[0] / 65535 - position.x) <= 4.0 / 65535 / 2 + 1e-7);
        CHECK(std::abs(room.low[1] + packed[1] * room.extent[1] / 65535 - position.y) <= 1.0 / 65535 / 2 + 1e-7);
        CHECK(packed[2] == 0);
        CHECK(std::abs(packed[4] / 65535.0 - uv.x) <= 0.5 / 65535 + 1e-7);
        CHECK(std::abs(packed[5] / 65535.0 - uv.y) <= 0.5 / 65535 + 1e-7);
    }
}

TEST_CASE("up is found from cameras that look down on all sides, and on one side")
{
    // About the world's y axis, which points down: a camera turned by `turn`, and down by `pitch`.
    const auto camera = [](double turn, double pitch)
    {
        Frame frame;
        const Mat3 turned{std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
        const Mat3 down{1, 0, 0, 0, std::cos(pitch), std::sin(pitch), 0, -std::sin(pitch), std::cos(pitch)};
        frame.color.world_from_camera.rotation = turned * down;
        return frame;
    };
    Frames around;
    for (const double turn : {0.0, 0.7, 1.5, 2.0})
        around.frames.push_back(camera(turn, 0.6));
    const Vec3d up = upwards(around);
    CHECK(up.y < -0.999);
    Frames one;
    one.frames.push_back(camera(0.3, 0.2));
    CHECK(upwards(one).y < -0.97);
}

TEST_CASE("a page holds videos up to a limit, and says which others there are")
{
    const testing::TemporaryFolder folder;
    ReportModel model;
    model.store = folder.path() / "store";
    model.out = folder.path() / "out";
    std::filesystem::create_directories(model.out);
    const std::vector<std::byte> bytes(7'000'000);
    for (const char* name : {"a.mp4", "b.webm", "c.mp4", "d.mp4"})
    {
        write_file(model.out / name, bytes);
        model.files.push_back({"fly", name, bytes.size()});
    }
    model.files.push_back({"fly", "e.mp4", 9'000'000});
    const ReportMedia media = report_media(model, stored_png::Codec());
    REQUIRE(media.pictures.size() == 3);
    CHECK(media.pictures[1].uri.starts_with("data:video/webm;base64,"));
    CHECK(media.notes == std::vector<std::string>{"d.mp4: the page has videos of 21.0 MB already; open the file",
                                                  "e.mp4: a video of 9.0 MB is not put into a page; open the file"});
}

TEST_CASE("what is chosen for a page is spread evenly")
{
    CHECK(evenly_spread(5, 12) == std::vector<std::size_t>{0, 1, 2, 3, 4});
    CHECK(evenly_spread(10, 4) == std::vector<std::size_t>{0, 2, 5, 7});
    CHECK(evenly_spread(0, 4).empty());
}
