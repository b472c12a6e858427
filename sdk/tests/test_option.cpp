#include "catch.h"

#include <fresco/component.h>
#include <fresco/option.h>
#include <fresco/testing.h>

using Catch::Contains;
using fresco::Value;

namespace
{

class Brush final : public fresco::Component
{
  public:
    static constexpr std::string_view component_kind = "brush";
    static constexpr std::string_view default_type = "brush.round";
    fresco::Option<double> width_px{this, "width_px", 3.0, fresco::range(0.5, 20), "Width of a stroke"};
};

class Painter final : public fresco::Configurable
{
  public:
    fresco::Option<int> strokes_count{this, "strokes_count", 10, fresco::range(1, 100), "How many strokes"};
    fresco::Option<std::string> style{this, "style", "wet", fresco::one_of({"wet", "dry"}), "How the paint lies"};
    fresco::Option<std::vector<double>> color{this, "color", {0.0, 0.5, 1.0}, fresco::range(0, 1), "RGB"};
    fresco::Option<fresco::InputFile> sketch{this, "sketch", fresco::required, fresco::extensions({".png", ".jpg"}),
                                             "What to paint over"};
    fresco::Option<fresco::OutputName> path{this, "path", {"a.png"}, "Where to"};
    fresco::Option<bool> varnish{this, "varnish", false, "Shiny", fresco::not_in_key};
    fresco::Slot<Brush> brush{this, "brush", R"({"type": "brush.round", "width_px": 4})", "The brush"};
    fresco::SlotMap<Brush> more = fresco::SlotMap<Brush>{this, "more", "{}", "More brushes"};
    fresco::Option<int> any{this, "any", 1, "Any number"};
    fresco::Option<std::vector<int>> list{this, "list", std::vector<int>{}, fresco::at_least(0), "Numbers"};
    fresco::Option<std::int64_t> wide{this, "wide", 1, "A wide number"};
};

}  // namespace

TEST_CASE("An option's declaration is all that a reader of the pipeline needs")
{
    const Painter painter;
    const Value description = painter.describe();
    const auto& options = description.at("options").as_list();
    REQUIRE(options.size() == 11);
    CHECK(options[0] == fresco::parse_json(R"({"name": "strokes_count", "kind": "int", "default": 10, "min": 1.0, "max": 100.0,
                                               "help": "How many strokes"})"));
    CHECK(options[1].at("choices") == Value(Value::List{"wet", "dry"}));
    CHECK(options[3].at("required").as_bool());
    CHECK(options[3].find("default") == nullptr);
    CHECK(options[3].at("extensions") == Value(Value::List{".png", ".jpg"}));
    const auto sketch = fresco::OptionDeclaration::from(options[3]);
    CHECK(sketch.accepted() == "the path of an existing file (.png or .jpg)");
    CHECK(sketch.describe() == options[3]);
    CHECK_FALSE(options[5].at("in_key").as_bool());
    CHECK(options[6].at("default").at("width_px").as_int() == 4);
    CHECK(options[7].at("kind").as_string() == "components");
    // Whole numbers have the range of their type, so that what a run would refuse is refused before.
    CHECK(options[8].at("min").as_double() == -2147483648.0);
    CHECK((options[9].at("min").as_double() == 0 && options[9].at("max").as_double() == 2147483647.0));
    CHECK(options[10].find("max") == nullptr);
}

TEST_CASE("Values are taken, and what does not fit is refused by name")
{
    Painter painter;
    fresco::testing::TestFactory factory;
    factory.add("brush.round", [] { return std::make_shared<Brush>(); });
    const auto set = [&](const char* name, Value value) { painter.configure(Value::Map{{name, std::move(value)}}, factory); };
    set("strokes_count", 7);
    set("color", Value::List{1, 0, 0.25});
    set("any", 2147483647);
    set("wide", std::numeric_limits<std::int64_t>::max());
    set("brush", Value::Map{{"type", "brush.round"}});
    CHECK((*painter.strokes_count == 7 && *painter.any == 2147483647));
    CHECK(*painter.wide == std::numeric_limits<std::int64_t>::max());
    CHECK((*painter.color)[2] == 0.25);
    CHECK_THROWS_WITH(set("list", Value::List{std::int64_t{2147483648}}), Contains("0 to 2147483647"));
    CHECK(*painter.brush->width_px == 3.0);
    CHECK_THROWS_WITH(set("strokes_count", 101), Contains("strokes_count") && Contains("101") && Contains("1 to 100"));
    CHECK_THROWS_WITH(set("stroke", 1), Contains("unknown option"));
    CHECK_THROWS_WITH(set("brush", Value::Map{{"type", "brush.flat"}}), Contains("brush.flat"));
}

TEST_CASE("A slot that may be empty says so, and one that the pipeline fills for all stages is listed apart from the options")
{
    struct Palette : fresco::Configurable
    {
        fresco::Slot<Brush> needed{this, "needed", "brush.round", "Must be there"};
        fresco::Slot<Brush> other{this, "other", "", "None unless given"};
        fresco::Slot<Brush> shared{this, fresco::optional, "Draws"};
    };
    Palette palette;
    const Value description = palette.describe();
    const auto& options = description.at("options").as_list();
    REQUIRE(options.size() == 2);
    CHECK(options[0].find("optional") == nullptr);
    CHECK(options[1].at("optional").as_bool());
    CHECK(description.at("components") == fresco::parse_json(R"([{"name": "brush", "kind": "component", "component_kind": "brush",
                                  "default": {"type": "brush.round"}, "optional": true, "help": "Draws"}])"));
    fresco::testing::TestFactory factory;
    factory.add("brush.round", [] { return std::make_shared<Brush>(); });
    palette.configure(Value::Map{{"brush", Value::Map{{"type", "brush.round"}, {"width_px", 2.0}}}}, factory);
    CHECK(*palette.shared->width_px == 2);
    CHECK_FALSE(palette.other.has_value());
    CHECK_THROWS_WITH(*palette.needed, Contains("\"needed\": no component of kind brush"));
}
