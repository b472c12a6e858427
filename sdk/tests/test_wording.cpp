#include "catch.h"

#include <fresco/random.h>
#include <fresco/wording.h>

using namespace fresco;

namespace
{

/// By its definition.
std::size_t plain_distance(std::string_view a, std::string_view b)
{
    if (a.empty() || b.empty())
        return a.size() + b.size();
    const auto rest_a = a.substr(1);
    const auto rest_b = b.substr(1);
    std::size_t best = plain_distance(rest_a, rest_b) + (a[0] == b[0] ? 0 : 1);
    best = std::min({best, plain_distance(rest_a, b) + 1, plain_distance(a, rest_b) + 1});
    if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0])
        best = std::min(best, plain_distance(a.substr(2), b.substr(2)) + 1);
    return best;
}

std::string random_word(Random& random, std::size_t longest)
{
    std::string word;
    for (auto left = static_cast<std::size_t>(random.uniform() * static_cast<double>(longest + 1)); left > 0; --left)
        word += random.uniform() < 0.4 ? 'a' : random.uniform() < 0.5 ? 'b' : 'c';
    return word;
}

}  // namespace

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

TEST_CASE("The nearest of many words is the first that no other is nearer than", "[suggest]")
{
    Random random(3);
    for (int trial = 0; trial < 200; ++trial)
    {
        const std::string word = random_word(random, 6);
        std::vector<std::string> candidates;
        std::string expected;
        std::size_t best = std::max<std::size_t>(1, (word.size() + 2) / 3) + 1;
        for (int i = 0; i < 8; ++i)
        {
            const std::string& candidate = candidates.emplace_back(random_word(random, 5));
            const std::size_t distance = plain_distance(word, candidate);
            CAPTURE(word, candidate);
            CHECK(edit_distance(word, candidate) == distance);
            if (distance < best && distance < std::max(word.size(), candidate.size()))
            {
                best = distance;
                expected = candidate;
            }
        }
        CAPTURE(word, candidates);
        const std::string found = nearest(word, candidates);
        // Without a near one, a candidate that holds the word is meant.
        CHECK((found == expected || (expected.empty() && found.find(word) != std::string::npos)));
    }
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
