#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/hole_closer.h>

#include <fresco/testing_scenes.h>

using namespace fresco;

TEST_CASE("the component reports what it closed, by the depth of the frames that it is given")
{
    // A box of 1 m without its lid, whose opening is 1.41 m wide.
    Mesh open = testing::box();
    open.triangles.resize(10);
    std::vector<const Frame*> measured;
    int reads = 0;
    const auto run_with = [&](double width_cm, testing::TestRun& run)
    {
        return testing::configured<HoleCloser>("mesh.close_holes", Value::Map{{"max_width_cm", width_cm}})
            ->closed(
                open, measured,
                [&](const Frame&)
                {
                    ++reads;
                    return RasterF(64, 48, 1, 1.0F);
                },
                run);
    };
    testing::TestRun closing;
    CHECK(run_with(150, closing).triangles.size() > 11);
    CHECK(closing.reported.at("holes_closed").as_int() == 1);
    CHECK(closing.reported.at("added_area_m2").as_double() == Approx(1).epsilon(0.3));
    testing::TestRun leaving;
    CHECK(run_with(100, leaving).triangles.size() == 10);
    CHECK(leaving.reported.at("holes_too_large").as_int() == 1);
    // The component looks at every third of 401 frames.
    const std::vector<Frame> frames(401, testing::frame("frame-0", testing::camera(64, 48, 50)));
    for (const Frame& frame : frames)
        measured.push_back(&frame);
    run_with(150, closing);
    CHECK(reads == 134);
}
