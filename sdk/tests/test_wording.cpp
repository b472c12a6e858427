#include <catch2/catch.hpp>

#include <fresco/wording.h>

using namespace fresco;

TEST_CASE("Edit distance counts single edits and swaps", "[suggest]")
{
    CHECK(edit_distance("", "") == 0);
    CHECK(edit_distance("abc", "") == 3);
    CHECK(edit_distance("abc", "abc") == 0);
    CHECK(edit_distance("abc", "acb") == 1);
    CHECK(edit_distance("ca", "abc") == 3);  // Optimal string alignment: a swapped pair is not edited again.
    CHECK(edit_distance("kitten", "sitting") == 3);
}

TEST_CASE("The nearest spelling is found, and nothing far-fetched", "[suggest]")
{
    const std::vector<std::string> names{"max_faces", "keep_borders", "method"};
    CHECK(nearest("max_face", names) == "max_faces");
    CHECK(nearest("max-faces", names) == "max_faces");
    CHECK(nearest("Method", names) == "method");
    CHECK(nearest("mehtod", names) == "method");
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
