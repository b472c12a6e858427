#include "catch.h"
#include "figure_table.h"

using fresco::Value;

TEST_CASE("mean and worst of views, by what is wanted")
{
    const std::vector<std::string> views{"a", "b", "c", "d"};
    const auto worst = [&](Wanted wanted, const std::vector<double>& values)
    { return over_views("figure", wanted, values, views)->worst->view; };
    CHECK(worst({0.5}, {0.9, 0.4, 0.7, 0.8}) == "b");
    CHECK(worst({.high = 0.005}, {0.001, 0, 0.004, 0.002}) == "c");
    CHECK(worst({0.8, 1.2}, {1, 0.9, 1.15, 0.95}) == "c");
    CHECK(worst({0.8, 1.2}, {1, 0.7, 1.25, 0.95}) == "b");
    // The first of equal ones; views without a value do not count.
    CHECK(worst({0.5}, {std::nan(""), 0.4, 0.4, 0.8}) == "b");
    const auto some = over_views("figure", {0.5}, std::vector<double>{1, std::nan(""), INFINITY, 2}, views);
    CHECK(some->value == 1.5);
    CHECK_FALSE(over_views("figure", {0.5}, std::vector<double>(4, std::nan("")), views));
}

TEST_CASE("figures as a table, as JSON and in a line")
{
    const std::vector<Figure> figures{{"coherence", 0.914, Figure::Worst{0.7, "s_1"}, {0.8, 1.2}},
                                      {"off_palette", 0.0123456, Figure::Worst{0.5, "s_2"}, {.high = 0.005}},
                                      {"picture_used", 0.25, std::nullopt, {.low = 0.4}}};
    const Value shown = table(figures);
    CHECK(to_json(shown.at("columns")) == R"(["figure","mean","worst","worst view","wanted","reached"])");
    CHECK(to_json(shown.at("rows")) == R"([["coherence","0.914","0.7","s_1","0.8 to 1.2","yes"],)"
                                       R"(["off_palette","0.0123","0.5","s_2","at most 0.005","no"],)"
                                       R"(["picture_used","0.25","","","at least 0.4","no"]])");
    CHECK(to_json(figures_value(figures)) ==
          R"({"coherence":{"mean":0.914,"worst":0.7,"worst_view":"s_1","at_least":0.8,"at_most":1.2,"reached":true},)"
          R"("off_palette":{"mean":0.0123456,"worst":0.5,"worst_view":"s_2","at_most":0.005,"reached":false},)"
          R"("picture_used":{"value":0.25,"at_least":0.4,"reached":false}})");
    CHECK(values_line(figures) == "coherence 0.914, off_palette 0.0123, picture_used 0.25");
    CHECK(
        ranges_line(figures) ==
        "1 of 3 figures in the wanted range; off_palette 0.0123 (wanted at most 0.005), picture_used 0.25 (wanted at least 0.4)");
    CHECK(ranges_line({figures[0]}) == "1 of 1 figures in the wanted range");
}
