#include "catch.h"

#include <fresco/command.h>

using namespace fresco;
using Words = std::vector<std::string>;

TEST_CASE("names in braces are found and filled in, doubled braces are braces", "[command_line]")
{
    CHECK(names_in("--out={result}") == Words{"result"});
    CHECK(names_in("{a}:{b.py}") == Words{"a", "b.py"});
    CHECK(names_in("{{\"a\": 1}}").empty());
    CHECK(filled_in("{{{a}}}", {{"a", "/x y"}}) == "{/x y}");
    CHECK(filled_in("plain", {}) == "plain");
    for (const char* word : {"{", "}", "{a", "a}", "{a{b}}", "{{a}"})
    {
        INFO(word);
        CHECK_THROWS_WITH(names_in(word), Catch::Contains("without its other"));
    }
    CHECK_THROWS_WITH(filled_in("{b}", {{"a", ""}}), Catch::Contains("unknown name {b}"));
}
