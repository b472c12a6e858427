#include "catch.h"
#include "frame_pairs.h"

namespace
{
const std::vector<FramePlace> recorded{{"a", 0}, {"a", 8}, {"a", 16}, {"a", 24}, {"a", 40}, {"b", 8}, {"b", 48}};
}

TEST_CASE("the paper's pairs are recorded numbers apart, within a sequence")
{
    CHECK(frame_pairs(recorded, 8, Protocol::paper) == std::vector<FramePair>{{0, 1}, {1, 2}, {2, 3}});
    CHECK(frame_pairs(recorded, 24, Protocol::paper) == std::vector<FramePair>{{0, 3}, {2, 4}});
    CHECK(frame_pairs(recorded, 40, Protocol::paper) == std::vector<FramePair>{{0, 4}, {5, 6}});
    CHECK(frame_pairs(recorded, 2, Protocol::paper).empty());
}

TEST_CASE("the released pairs are list positions apart, backwards first")
{
    CHECK(frame_pairs(recorded, 1, Protocol::released) ==
          std::vector<FramePair>{{0, 1}, {1, 0}, {2, 1}, {3, 2}, {4, 3}, {5, 6}, {6, 5}});
    CHECK(frame_pairs(recorded, 3, Protocol::released) == std::vector<FramePair>{{0, 3}, {1, 4}, {3, 0}, {4, 1}});
    CHECK(frame_pairs(recorded, 10, Protocol::released).empty());
}

TEST_CASE("the smallest gap within a sequence")
{
    CHECK(smallest_gap(recorded) == 8);
    CHECK(smallest_gap({{"a", 24}, {"b", 25}, {"a", 4}}) == 20);
    CHECK(smallest_gap({{"a", 24}, {"b", 25}}) == 0);
}
