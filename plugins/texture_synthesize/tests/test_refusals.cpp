#include "studio.h"

using namespace studio;

TEST_CASE("the stage says what it cannot use")
{
    struct Case
    {
        const char* name;
        std::function<void(Studio&, Value&)> change;
        std::vector<const char*> texts;
    };
    const Case cases[] = {
        {"no atlas", [](Studio& s, Value&) { s.mesh.texcoords.clear(); }, {"port 'mesh'", "no texcoords", "atlas."}},
        {"a start of another atlas", [](Studio& s, Value&) { s.start.atlas = std::string(32, 'a'); }, {"port 'start'", "atlas"}},
        {"a start that knows nothing",
         [](Studio& s, Value&) { s.start.seen = Raster8(96, 96); },
         {"port 'start'", "has no texel"}},
        {"a small picture",
         [](Studio& s, Value& o)
         {
             s.picture = brush_picture(5, 60, 1);
             o.set("patch_px", 11);
         },
         {"style picture", "5x60", "smaller than one patch of 11"}},
        {"a picture whose strokes are large",
         [](Studio& s, Value& o)
         {
             s.picture = brush_picture(40, 40, 1, 9);
             o.set("levels_count", 4);
             o.set("patch_px", 21);
         },
         {"style picture", "40x40", "smaller than one patch of 21"}},
        {"a constant picture",
         [](Studio& s, Value&) { s.picture = Raster8(96, 96, 3, 120); },
         {"style picture", "a single color"}},
        {"a constant picture, large patches",
         [](Studio& s, Value& o)
         {
             s.picture = Raster8(96, 96, 3, 120);
             o.set("patch_px", 21);
         },
         {"a single color"}},
        {"a constant picture, many levels",
         [](Studio& s, Value& o)
         {
             s.picture = Raster8(20, 20, 3, 0);
             o.set("levels_count", 4);
         },
         {"a single color"}},
        {"a gray picture",
         [](Studio& s, Value&) { s.picture = Raster8(96, 96, 1, 120); },
         {"style picture", "1 channels", "RGB"}},
        {"narrow strokes",
         [](Studio&, Value& o) { o.set("stroke_cm", 0.5); },
         {"strokes of 0.5 cm", "stroke_cm", "too narrow", "2.6 cm", "5.21 or more", "size_px"}},
        {"strokes of less than two texels",
         [](Studio&, Value& o) { o.set("stroke_cm", 5.2); },
         {"strokes of 5.2 cm", "too narrow"}},
        {"strokes wider than the room",
         [](Studio&, Value& o) { o.set("stroke_cm", 201); },
         {"strokes of 201 cm", "stroke_cm", "wider than the room", "200 cm long"}},
        {"a mesh in kilometers",
         [](Studio& s, Value&)
         {
             for (Vec3f& position : s.mesh.positions)
                 position = position * 0.001F;
             s.start.atlas.clear();
         },
         {"wider than the room", "unit_m"}},
        {"an even patch", [](Studio&, Value& o) { o.set("patch_px", 8); }, {"\"patch_px\" is 8", "odd"}},
        {"a patch too large", [](Studio&, Value& o) { o.set("patch_px", 33); }, {"patch_px"}},
        {"an atlas without area",
         [](Studio& s, Value&)
         {
             s.mesh.texcoords.assign(12, {0.5F, 0.5F});
             s.start.atlas.clear();
         },
         {"mesh"}},
        {"a mesh in millimeters",
         [](Studio& s, Value&)
         {
             for (Vec3f& position : s.mesh.positions)
                 position = position * 100000.0F;
             s.start.atlas.clear();
         },
         {"strokes of 16 cm are too narrow", "unit_m"}},
        {"a face out of range",
         [](Studio& s, Value&)
         {
             s.mesh.triangles[0][0] = 99;
             s.start.atlas.clear();
         },
         {"port 'mesh'"}},
        {"a start that is no number", [](Studio& s, Value&) { s.start.layers[0].values[5] = NAN; }, {"finite"}}};
    for (const Case& c : cases)
    {
        CAPTURE(c.name);
        Studio wall;
        Value options = Studio::options();
        c.change(wall, options);
        testing::TestRun run;
        std::string error;
        try
        {
            wall.paint(run, options);
        }
        catch (const Error& e)
        {
            error = e.what();
        }
        for (const char* text : c.texts)
            CHECK_THAT(error, Catch::Contains(text));
    }
}
