#include "catch.h"
#include "hand_made_catalog.h"

#include "run/run_state.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <random>

using namespace fresco;
using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{

Catalog catalog_of_nodes()
{
    const std::string seed = R"({"name": "seed", "kind": "int", "default": 0, "help": ""})";
    Catalog catalog;
    catalog.add(stage("n.plain", "a mesh?, b mesh?, c mesh?", "mesh mesh", seed));
    catalog.add(stage("n.files", "a mesh?, b mesh?, c mesh?", "mesh mesh, files files", seed));
    return catalog;
}

/// Each stage reads up to three before it.
std::string random_pipeline(int count, std::mt19937& random)
{
    std::string text = "version: 1\nstages:\n";
    for (int i = 0; i < count; ++i)
    {
        std::string wires;
        for (const char* port : {"a", "b", "c"})
            if (i > 0 && random() % 2 == 0)
                wires += (wires.empty() ? "" : ", ") + std::string(port) + ": s" +
                         std::to_string(random() % static_cast<unsigned>(i)) + ".mesh";
        text += "  s" + std::to_string(i) + ": {type: " + (random() % 6 == 0 ? "n.files" : "n.plain") +
                ", seed: " + std::to_string(i) + (wires.empty() ? "" : ", input: {" + wires + "}") + "}\n";
    }
    return text;
}

/// Every stage must be as an update of the whole graph leaves it.
void check_against_whole_update(const RunState& state)
{
    RunState whole = state;
    whole.update();
    for (std::size_t i = 0; i < state.nodes().size(); ++i)
    {
        const StageNode& node = state.nodes()[i];
        const StageNode& expected = whole.nodes()[i];
        INFO("stage " << i << ": " << to_string(node.state) << ", expected " << to_string(expected.state));
        REQUIRE(node.state == expected.state);
        REQUIRE(node.present == expected.present);
        REQUIRE(node.key == expected.key);
        const auto is_present = [&](std::size_t producer) { return state.nodes()[producer].present; };
        REQUIRE(state.ready().contains(i) ==
                (node.state == StageState::waiting && std::ranges::all_of(node.producers, is_present)));
    }
    REQUIRE(state.ready() == whole.ready());
}

StoredResult made(const Store& store, const StageNode& node)
{
    const StoredResult result{object_id(node.key, {}), {}, {}};
    std::filesystem::create_directories(store.object(result.object));
    write_file(store.manifest_file(result.object), "{}");
    store.remember(node.key, result);
    return result;
}

}  // namespace

TEST_CASE("After each change of one stage all states equal those of an update of the whole graph", "[run_state]")
{
    std::mt19937 random(7);
    const Catalog catalog = catalog_of_nodes();
    for (int round = 0; round < 12; ++round)
    {
        const TemporaryFolder folder;
        const PipelineResult pipeline = check(folder, random_pipeline(25, random), catalog);
        REQUIRE(lines(pipeline).empty());
        const Store store(folder.path() / "store");
        FileHashes hashes({});
        // The second time some results are gone, and some stages fail.
        for (const bool again : {false, true})
        {
            RunState state(pipeline.pipeline, store, hashes, random() % 3 == 0 ? "s20" : "");
            state.update();
            check_against_whole_update(state);
            std::set<std::size_t> arrived;
            const auto take_arrived = [&]
            {
                for (const std::size_t place : state.take_arrived())
                    CHECK(arrived.insert(place).second);
            };
            take_arrived();
            std::vector<std::size_t> running;
            while (!state.ready().empty() || !running.empty())
            {
                if (!state.ready().empty() && (running.empty() || random() % 2 == 0))
                {
                    const std::size_t place =
                        *std::next(state.ready().begin(), static_cast<long>(random() % state.ready().size()));
                    state.nodes()[place].state = StageState::running;
                    state.update(state.nodes()[place]);
                    running.push_back(place);
                }
                else
                {
                    std::swap(running.back(), running[random() % running.size()]);
                    StageNode& node = state.nodes()[running.back()];
                    running.pop_back();
                    if (again && random() % 8 == 0)
                        node.state = StageState::failed;
                    else
                    {
                        node.result = made(store, node);
                        node.present = true;
                        node.state = StageState::done;
                    }
                    state.update(node);
                }
                check_against_whole_update(state);
                take_arrived();
            }
            for (std::size_t i = 0; i < state.nodes().size(); ++i)
                CHECK(arrived.contains(i) ==
                      (state.nodes()[i].state == StageState::done || state.nodes()[i].state == StageState::stored));
            for (const auto& object : std::filesystem::directory_iterator(store.root() / "objects"))
                if (random() % 3 == 0)
                    std::filesystem::remove_all(object);
        }
    }
}
