#include "catch.h"
#include "hand_made_catalog.h"

#include "run/plan.h"

#include <algorithm>
#include <chrono>
#include <cstdint>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
/// splitmix64: the same mutations everywhere.
class Random
{
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::size_t below(std::size_t limit)
    {
        state_ += 0x9E3779B97F4A7C15U;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
        return static_cast<std::size_t>((z ^ (z >> 31U)) % limit);
    }

  private:
    std::uint64_t state_;
};

const std::string sample = R"(version: 1
vars: {data: scan, picture: pic.jpg, weights: "", n: [16, 32]}
matrix: {n: [[16, 32], [48]], data: {here: scan}}
stages:
  scan:    {type: scan.folder, path: "${data}"}   # the scan
  frames:  {type: frames.sharpest, input: scan, min_sharpness: 1.5e2}
  mesh:
    type: mesh.decimate
    input: scan
    max_faces: 400000
    method: 'edge'
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: mesh, frames: frames}, heights_px: "${n}"}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: frames, style: {file: "${picture}"}}
    weights: "${weights}"
    losses: {style: {type: loss.gram, features: {type: features.edges, seed: 3}}, content: loss.content}
  glb:     {type: export.gltf, input: texture, path: room.glb}
)";

std::string mutated(Random& random)
{
    static const std::vector<std::string> bits{"{",        "}",
                                               "[",        "]",
                                               ":",        ": ",
                                               ",",        "\n",
                                               "\n  ",     "- ",
                                               "&a ",      "*a",
                                               "<<: ",     "!t ",
                                               "'",        "\"",
                                               "|\n",      ">\n",
                                               "#",        "---\n",
                                               "...\n",    "\t",
                                               "${data}",  "${",
                                               "~",        "? ",
                                               "%",        "\xff",
                                               "\xc3\xa9", "010",
                                               "1e999",    ".nan",
                                               "null",     "true",
                                               "scan",     "type: ",
                                               "input: ",  std::string(1, '\0')};
    std::string text = sample;
    for (std::size_t count = 1 + random.below(4); count > 0; --count)
    {
        const std::size_t at = random.below(text.size() + 1);
        const std::size_t length = std::min(random.below(12), text.size() - at);
        switch (random.below(5))
        {
        case 0:
            text.erase(at, length);
            break;
        case 1:
            text.insert(at, bits[random.below(bits.size())]);
            break;
        case 2:
            text.insert(random.below(text.size() + 1), text.substr(at, 8 * length));
            break;
        case 3:
            text.resize(at);
            break;
        default:
            if (at < text.size())
                text[at] = static_cast<char>(random.below(256));
        }
    }
    return text;
}
}  // namespace

TEST_CASE("Mutated pipeline files end in a pipeline or in problems with their places", "[pipeline]")
{
    const TemporaryFolder folder;
    folder.write("scan/a.png", "1");
    folder.write("pic.jpg", jpeg_text);
    const Catalog catalog = hand_made_catalog();
    REQUIRE(lines(check(folder, sample, catalog)).empty());
    Random random(2022);
    int good = 0;
    const auto start = std::chrono::steady_clock::now();
    for (int round = 0; round < 1500; ++round)
    {
        const std::string text = mutated(random);
        INFO(text);
        const PipelineResult result =
            check(folder, text, catalog, round % 3 == 0 ? Sets{{"texture.losses.style.weight", "2"}} : Sets{});
        REQUIRE(result.pipeline.stages.empty() == !result.problems.empty());
        good += result.problems.empty() ? 1 : 0;
        for (const Problem& problem : result.problems)
        {
            CHECK_FALSE(problem.text.empty());
            CHECK(problem.position.file.find(problem.position.line > 0 ? "p.yaml" : "") == 0);
            CHECK(problem.position.line <= 1 + std::count(text.begin(), text.end(), '\n'));
        }
        estimate_pipeline(result.pipeline, 2);
    }
    // Some leave the file good (in comments and numbers), most do not.
    CHECK(good > 10);
    CHECK(good < 1000);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
}
