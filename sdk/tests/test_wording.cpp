#include "catch.h"

#include <fresco/wording.h>

using namespace fresco;

TEST_CASE("The nearest spelling is found, and nothing far-fetched", "[suggest]")
{
    const std::vector<std::string> names{"max_faces", "keep_borders", "method"};
    CHECK(nearest("max_face", names) == "max_faces");
    CHECK(nearest("max-faces", names) == "max_faces");
    CHECK(nearest("Method", names) == "method");
    CHECK(nearest("mehtod", names) == "method");
    // Two letters of six may be wrong: each takes one to insert, remove, replace or swap with its neighbor.
    CHECK(nearest("etohd", names) == "method");
    CHECK(nearest("mthdos", names) == "");
    CHECK(nearest("ab", {"abc", "aab", "ab", "b"}) == "ab");
    CHECK(nearest("ab", {"abc", "aab"}) == "abc");
    CHECK(nearest("faces", names) == "max_faces");
    CHECK(nearest("color", names) == "");
    CHECK(nearest("b", {"a"}) == "");
    CHECK(nearest("decimate", {"mesh.decimate", "frames.sharpest"}) == "mesh.decimate");
}

TEST_CASE("A suggestion lists what there is where nothing is near", "[suggest]")
{
    CHECK(suggestion("metod", {"method", "size"}) == " (did you mean 'method'?)");
    CHECK(suggestion("color", {"method", "size"}) == " (there are: method, size)");
    CHECK(suggestion("color", {"method", "size"}, 1) == " (there are: method, …)");
    CHECK(suggestion("color", {}) == "");
    CHECK(join({}) == "");
    CHECK(join({"a", "b", "c"}) == "a, b and c");
    CHECK(join({"a", "b"}, " or ") == "a or b");
}
