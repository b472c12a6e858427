#include "catch.h"
#include "hand_made_catalog.h"

#include <atomic>
#include <cstdlib>
#include <new>
#include <set>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{

/// `scans` times `pictures` combinations: two stages per scan, one per picture, two of both.
std::string matrix_of(int scans, int pictures)
{
    std::string text = "version: 1\nvars: {scan: , picture: }\nmatrix:\n  scan:\n";
    for (int i = 0; i < scans; ++i)
        text += "  - scan" + std::to_string(i) + "\n";
    text += "  picture:\n";
    for (int i = 0; i < pictures; ++i)
        text += "  - picture" + std::to_string(i) + "\n";
    return text + R"(stages:
  scan_of: {type: mesh.pass, title: "${scan}"}
  mesh: {type: mesh.pass, input: scan_of}
  colors: {type: mesh.pass, title: "${picture}"}
  texture: {type: mesh.pass, input: mesh, title: "${picture}"}
  bake: {type: mesh.pass, input: texture}
)";
}

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // They replace the operators, too.
namespace
{
std::atomic<std::size_t> allocations{0};
}  // namespace

// Of this test program only: counts, so that a test of how much work is done need not measure time. Not inlined, where the
// compiler would see free() end what new began.
[[gnu::noinline]] void* operator new(std::size_t size)
{
    ++allocations;
    if (void* memory = std::malloc(size > 0 ? size : 1))
        return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

TEST_CASE("four times as many combinations are hardly more than four times the work")
{
    const TemporaryFolder folder;
    const Catalog catalog = hand_made_catalog();
    const auto work = [&](int pictures)
    {
        const std::string text = matrix_of(10, pictures);
        const std::size_t before = allocations;
        const auto result = check(folder, text, catalog);
        const std::size_t count = allocations - before;
        CHECK(lines(result).empty());
        CHECK(result.pipeline.sweep.combinations.size() == static_cast<std::size_t>(10 * pictures));
        CHECK(result.pipeline.stages.size() == static_cast<std::size_t>(20 + pictures + 20 * pictures));
        return static_cast<double>(count);
    };
    work(1);
    const double once = work(50);
    const double four_times = work(200);
    CHECK(four_times < 5 * once);
    // A combination is not checked, only listed: that would take thousands.
    CHECK(four_times / 2000 < 200);
}
#endif

TEST_CASE("stages share their options where these are the same in several combinations")
{
    const TemporaryFolder folder;
    const auto result = check(folder, matrix_of(10, 30), hand_made_catalog());
    std::set<const fresco::Value*> of_texture;
    std::set<const fresco::Value*> of_bake;
    for (const PipelineStage& stage : result.pipeline.stages)
        if (stage.own_name == "texture")
            of_texture.insert(stage.options.get());
        else if (stage.own_name == "bake")
            of_bake.insert(stage.options.get());
    CHECK(of_texture.size() == 30);
    CHECK(of_bake.size() == 1);
}

TEST_CASE("a part of a matrix has the stages of the whole, by the same names")
{
    const TemporaryFolder folder;
    folder.write("p.yaml", matrix_of(3, 4));
    const Catalog catalog = hand_made_catalog();
    const auto whole = load_pipeline({"p.yaml", {}, folder.path()}, catalog);
    PipelineRequest request{"p.yaml", {}, folder.path()};
    request.part =
        SweepPart{{{{"scan", "scan1"}, {"picture", "picture2"}}, {{"scan", "scan2"}}}, whole.pipeline.sweep.stage_axes};
    const auto part = load_pipeline(request, catalog);
    CHECK(lines(part).empty());
    std::vector<std::string> names;
    for (const PipelineStage& stage : part.pipeline.stages)
    {
        names.push_back(stage.name);
        const PipelineStage* same = whole.pipeline.find(stage.name);
        REQUIRE(same);
        CHECK(*stage.options == *same->options);
        CHECK(stage.place == same->place);
    }
    CHECK(names == std::vector<std::string>{"scan_of@scan1", "mesh@scan1", "colors@picture2", "texture@scan1,picture2",
                                            "bake@scan1,picture2", "scan_of@scan2", "mesh@scan2", "colors@picture0",
                                            "texture@scan2,picture0", "bake@scan2,picture0"});
    CHECK(part.pipeline.sweep.narrowed);
    request.part->combinations = {{{"scan", "scan7"}}};
    CHECK(lines(load_pipeline(request, catalog)).at(0).ends_with("the axis 'scan' of the matrix has no value 'scan7'"));
}

TEST_CASE("files that are handed over are read in place of those on the disk")
{
    const TemporaryFolder folder;
    folder.write("base.yaml", "version: 1\nstages:\n  a: {type: mesh.pass, size: 1}\n");
    folder.write("p.yaml", "version: 1\nbase: base.yaml\nstages:\n  a: {title: old}\n");
    const Catalog catalog = hand_made_catalog();
    PipelineRequest request{"p.yaml", {}, folder.path()};
    request.texts = load_pipeline(request, catalog).pipeline.texts;
    folder.write("base.yaml", "no longer a pipeline");
    std::filesystem::remove(folder.path() / "p.yaml");
    const auto result = load_pipeline(request, catalog);
    CHECK(lines(result).empty());
    CHECK(result.pipeline.find("a")->options->at("size").as_double() == 1);
    CHECK(result.pipeline.find("a")->options->at("title") == fresco::Value("old"));
}
