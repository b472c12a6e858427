#include "catch.h"
#include "judged_view.h"
#include "pictures.h"

using fresco::Raster8;
using fresco::Value;

TEST_CASE("views give means, the worst and a list, of what was measured in each")
{
    std::vector<JudgedView> views(3);
    views[0].name = "a";
    views[0].edges = 0.4;
    views[0].figures = {.off_palette = 0.25, .coherence = 1, .chroma_noise = 1, .strokes = 2};
    views[1].name = "b";
    views[1].edges = 0.8;
    views[2].name = "c";
    views[2].skipped = true;
    const auto figures = figures_over(views);
    REQUIRE(figures.size() == 5);
    CHECK(figures[0].name == "off_palette");
    CHECK(figures[0].value == 0.25);
    CHECK_FALSE(figures[0].is_inside());
    CHECK(figures[4].name == "edges");
    CHECK(figures[4].value == Approx(0.6));
    CHECK(figures[4].is_inside());
    CHECK(figures[4].worst->view == "a");
    CHECK(views_value(views) == fresco::parse_json(R"([
        {"view": "a", "off_palette": 0.25, "coherence": 1.0, "chroma_noise": 1.0, "strokes": 2.0, "edges": 0.4},
        {"view": "b", "edges": 0.8}, {"view": "c", "skipped": true}])"));
}

TEST_CASE("a view with too few pixels loads no camera picture and has no figures")
{
    const Raster8 small = pictures::painting(64, 64, 3);
    const auto judged = judged_view("small", small, nullptr,
                                    []() -> Raster8
                                    {
                                        FAIL("loaded");
                                        return {};
                                    });
    CHECK(judged.skipped);
    CHECK(figures_over({judged}).empty());
}
