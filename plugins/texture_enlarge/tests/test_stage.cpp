#include "catch.h"
#include "samples.h"

#include <fresco/stage.h>
#include <fresco/testing.h>

#include <functional>
#include <memory>

using namespace samples;

namespace
{

struct Enlarging
{
    Mesh mesh = fresco::testing::two_chart_wall();
    Raster8 picture = detailed_picture(128, 96);
    SourceMap source = patched_map(mesh, 64, picture, 2);
    int size_px = 256;

    std::shared_ptr<TexturedMesh> run(testing::TestRun& run) const
    {
        testing::TemporaryFolder folder;
        testing::run_stage(FRESCO_PLUGIN_FILE, "texture.enlarge", Value::Map{{"size_px", size_px}},
                           {{"source", std::make_shared<SourceMap>(source)},
                            {"style", std::make_shared<Image>(picture)},
                            {"mesh", std::make_shared<Mesh>(mesh)}},
                           folder.path(), run);
        return TexturedMesh::load({folder.path() / "textured_mesh", folder.path()});
    }
};

}  // namespace

TEST_CASE("the stage gives the mesh its picture and reports how fine it is")
{
    const Enlarging enlarging;
    testing::TestRun run;
    const auto result = enlarging.run(run);
    CHECK(result->mesh.texcoords == enlarging.mesh.texcoords);
    CHECK(result->image.pixels.width == 256);
    CHECK(result->image.pixels.height == 256);
    CHECK(run.reported.at("pixels_per_texel").as_double() == Approx(0.5));
    CHECK(run.reported.at("painted_share").as_double() == Approx(0.18).margin(0.03));
}

TEST_CASE("the stage says what it cannot use before it begins")
{
    struct Case
    {
        std::function<void(Enlarging&)> change;
        std::vector<const char*> texts;
    };
    const Case cases[] = {
        {[](Enlarging& e) { e.mesh.texcoords.clear(); }, {"port 'mesh'", "no texcoords", "atlas."}},
        {[](Enlarging& e) { e.source.atlas = std::string(32, 'a'); }, {"port 'source'", "atlas"}},
        {[](Enlarging& e) { e.picture = Raster8(128, 96, 4); }, {"style picture", "4 channels", "RGB"}},
        {[](Enlarging& e) { e.picture = detailed_picture(128, 128); }, {"128x128", "128x96", "same picture"}},
        {[](Enlarging& e) { e.size_px = 48; }, {"size_px 48", "source map's 64", "texture.bake"}},
        {[](Enlarging& e) { e.size_px = 512; },
         {"size_px 512", "0.25 pixels", "size_px to 256 at most", "256 pixels wide (it has 128)", "stroke_cm"}},
        {[](Enlarging& e)
         {
             e.source.pixels_per_texel = 0.4F;
             e.size_px = 64;
         },
         {"size_px 64", "0.4 pixels", "holds no more detail: wire", "160 pixels wide"}},
    };
    for (const Case& what : cases)
    {
        Enlarging enlarging;
        what.change(enlarging);
        testing::TestRun run;
        std::string message;
        try
        {
            enlarging.run(run);
        }
        catch (const Error& error)
        {
            message = error.what();
        }
        CAPTURE(message);
        for (const char* text : what.texts)
            CHECK(message.find(text) != std::string::npos);
    }
}
