#include "catch.h"

#include <fresco/uv_mapping/view_frames.h>

#include <vector>

using namespace fresco;

TEST_CASE("views of uv maps find their frames by sequence and name, in any order")
{
    UvMaps maps;
    maps.views = {{"b", "0", {}, {}}, {"a", "1", {}, {}}, {"a", "0", {}, {}}};
    Frames frames;
    for (const auto& [sequence, name] : {std::pair{"a", "0"}, {"x", "9"}, {"a", "1"}, {"b", "0"}})
    {
        Frame frame;
        frame.sequence = sequence;
        frame.name = name;
        frames.frames.push_back(frame);
    }
    CHECK(frames_of_views(maps, frames) == std::vector<std::size_t>{3, 2, 0});
    frames.frames.erase(frames.frames.begin() + 2);
    CHECK_THROWS_WITH(frames_of_views(maps, frames), Catch::Contains("a/1, which is missing on port 'frames'"));
}
