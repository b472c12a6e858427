#include "catch.h"
#include "exported_files.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/page/page.h>
#include <fresco/relief.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <memory>

using namespace fresco;

namespace
{
TexturedMesh square(int side)
{
    TexturedMesh textured;
    textured.mesh = testing::wall(0.5F);
    textured.image = Image(Raster8(side, side, 3, 77));
    return textured;
}

struct Exported
{
    std::string page;
    Value data;
    Value report;
};

Exported exported(const Value& options, testing::Inputs more = {}, int side = 8)
{
    more["textured_mesh"] = std::make_shared<TexturedMesh>(square(side));
    const auto files = exported_files::exported_by("export.page", options, more);
    Exported result{files.file, {}, files.report};
    const std::string begin = "<script type=\"application/json\" id=\"data\">";
    const std::size_t at = result.page.find(begin) + begin.size();
    result.data = parse_json(result.page.substr(at, result.page.find("</script>", at) - at));
    return result;
}
}  // namespace

TEST_CASE("the page holds the room and all scripts, and names no other file")
{
    const Exported result = exported(Value::Map{{"up", "-y"}, {"path", "rooms/a<b.html"}});
    CHECK_THAT(result.page, Catch::StartsWith("<!doctype html>") && Catch::EndsWith("</html>\n"));
    CHECK_THAT(result.page,
               Contains("<title>a&lt;b</title>") && Contains("OrbitControls") && Contains("async function showRoom"));
    for (const char* outside : {"src=\"http", "href=\"http", "@import", "<link rel=\"stylesheet"})
        CHECK_THAT(result.page, !Contains(outside));
    CHECK(result.data.at("room").at("triangles") == Value(2));
    CHECK(result.data.at("cameras").is_null());
    CHECK(result.data.at("up").as_list().at(1).as_double() == Approx(-1));
    CHECK(result.report.at("bytes") == Value(result.page.size()));
    CHECK(result.report.at("triangles") == Value(2));
}

TEST_CASE("the visitor begins where the first camera stood")
{
    const auto frames = std::make_shared<Frames>();
    frames->frames.emplace_back().color.world_from_camera.translation = {1, 2, 3};
    frames->frames.emplace_back().color.world_from_camera.translation = {4, 5, 6};
    const Exported result = exported(Value::Map{{"up", "z"}}, {{"frames", frames}});
    CHECK(result.data.at("cameras").at("position") == Value(Value::List{1.0, 2.0, 3.0}));
    CHECK(result.data.at("cameras").at("forward") == Value(Value::List{0.0, 0.0, 1.0}));
}

TEST_CASE("the picture has at most 2048 texels a side unless told otherwise")
{
    CHECK(exported(Value::Map{{"up", "z"}}, {}, 2100).report.at("texture_px") == Value(2048));
    CHECK(exported(Value::Map{{"up", "z"}, {"max_texture_px", 4}}).report.at("texture_px") == Value(4));
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.htm"}}), Contains("ending in .html"));
}

TEST_CASE("a relief is in the page, in the world's axes")
{
    CHECK(exported(Value::Map{{"up", "z"}}).data.at("relief").is_null());
    const auto relief = exported_files::even_relief(square(8).mesh, {0, -1, 0});
    const Value data = exported(Value::Map{{"up", "z"}}, {{"relief", relief}}).data;
    const Raster8 along = testing::picture(8, 8, [](int, int, int c) { return c == 1 ? 0 : 128; });
    CHECK(data.at("relief").at("normals") == Value(page::data_uri("image/jpeg", exported_files::Codec().encode_png(along))));
    CHECK(data.at("relief").at("atlas") == data.at("room").at("atlas"));
    relief->atlas = "0123";
    CHECK_THROWS_WITH(exported(Value::Map{{"up", "z"}}, {{"relief", relief}}), Contains("the relief on port 'relief'"));
}
