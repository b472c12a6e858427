#include "catch.h"

#include <fresco/part_names.h>

using Names = std::vector<std::string>;

TEST_CASE("Rules name parts by any name in their paths, and by the paths")
{
    CHECK(fresco::names_in_path("house/kitchen/chair") == Names{"chair", "kitchen", "house"});
    CHECK(fresco::names_in_path("floor") == Names{"floor"});
    CHECK(fresco::names_for_rules({"floor", "house/chair", "house/table", "a//b"}) ==
          Names{"floor", "house", "chair", "table", "a", "b", "house/chair", "house/table", "a//b"});
}
