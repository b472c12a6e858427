#include "catch.h"
#include "hand_made_catalog.h"

#include "run/task_table.h"

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{

Catalog catalog_with_painter()
{
    Catalog catalog = hand_made_catalog();
    catalog.add(stage("paint", "mesh mesh", "mesh mesh",
                      R"({"name": "device", "kind": "text", "default": "cpu", "help": ""},
                         {"name": "picture", "kind": "text", "default": "", "help": ""})",
                      {.device = "device"}));
    return catalog;
}

std::string values(const std::string& prefix, int count)
{
    std::string text;
    for (int i = 0; i < count; ++i)
        text += (i == 0 ? "" : ", ") + prefix + std::to_string(i);
    return "[" + text + "]";
}

/// A scan is prepared by two stages, painted on a GPU and baked.
std::string painting(int scans, int pictures)
{
    return "version: 1\nvars: {scan: , picture: }\nmatrix: {scan: " + values("s", scans) + ", picture: " + values("p", pictures) +
           R"(}
stages:
  bake: {type: mesh.pass, input: paint}
  paint: {type: paint, input: mesh, picture: "${picture}", device: cuda}
  scan_of: {type: mesh.pass, title: "${scan}"}
  mesh: {type: mesh.pass, input: scan_of}
  legend: {type: mesh.pass}
)";
}

struct Loaded
{
    Catalog catalog = catalog_with_painter();
    TemporaryFolder folder;
    PipelineResult result;

    explicit Loaded(const std::string& text) : result(check(folder, text, catalog)) { REQUIRE(lines(result) == Words{}); }
    const Pipeline& pipeline() const { return result.pipeline; }
    std::vector<bool> all() const { return std::vector<bool>(pipeline().stages.size(), true); }
    /// That every stage takes so long.
    std::map<std::string, CostFigures> each(double seconds) const
    {
        std::map<std::string, CostFigures> estimates;
        for (const PipelineStage& stage : pipeline().stages)
            estimates[stage.name] = {seconds, 100, 1};
        return estimates;
    }
};

TaskTable small_table(const Loaded& loaded)
{
    TaskTable table = make_task_table(loaded.pipeline(), loaded.all(), loaded.each(1), {0, 2});
    table.pipeline = {loaded.pipeline().file, {{"paint.device", "cuda"}}, loaded.folder.path(), "", true,
                      loaded.pipeline().texts};
    table.plugins["paint"] = {"/plugins/paint.so", "00"};
    return table;
}

/// What packing says, step by step and looking everything up each time. One string per task: the places of its combinations.
Words packed_slowly(const Loaded& loaded, const TaskTable& table, std::size_t group,
                    const std::map<std::string, CostFigures>& estimates, double limit)
{
    struct Piece
    {
        std::string place;
        double seconds = 0;
        std::set<std::size_t> needs;
        std::string leading() const { return place.substr(0, place.find(',')); }
    };
    const auto task_of = [&](const std::string& name) -> std::size_t
    {
        for (const Task& task : table.tasks)
            if (std::ranges::find(task.stages, name) != task.stages.end())
                return task.id;
        return table.tasks.size();
    };
    std::vector<Piece> pieces;
    for (const PipelineStage& stage : loaded.pipeline().stages)
    {
        const std::size_t task = task_of(stage.name);
        if (task == table.tasks.size() || table.tasks[task].group != group)
            continue;
        auto piece = std::ranges::find(pieces, stage.place, &Piece::place);
        if (piece == pieces.end())
            piece = pieces.insert(pieces.end(), {stage.place, 0, {}});
        piece->seconds += 0.3 + estimates.at(stage.name).seconds;
        for (const Wire& wire : stage.wires)
            if (const std::size_t maker = task_of(wire.from_stage);
                maker != table.tasks.size() && table.tasks[maker].group != group)
                piece->needs.insert(maker);
    }
    Words tasks;
    double open = 0;
    std::set<std::size_t> open_needs;
    for (std::size_t i = 0; i < pieces.size(); ++i)
    {
        bool joins = !tasks.empty() && open + pieces[i].seconds <= limit;
        if (i > 0 && pieces[i].leading() != pieces[i - 1].leading())
        {
            // All of the next scan, or none of it.
            double whole = 0;
            for (std::size_t j = i; j < pieces.size() && pieces[j].leading() == pieces[i].leading(); ++j)
            {
                whole += pieces[j].seconds;
                joins = joins && pieces[j].needs == open_needs;
            }
            joins = joins && open + whole <= limit;
        }
        if (!joins)
        {
            tasks.emplace_back();
            open = 0;
            open_needs.clear();
        }
        tasks.back() += pieces[i].place + ";";
        open += pieces[i].seconds;
        open_needs.insert(pieces[i].needs.begin(), pieces[i].needs.end());
    }
    return tasks;
}

Words packed(const TaskTable& table, std::size_t group)
{
    Words tasks;
    for (const Task& task : table.tasks)
        if (task.group == group)
        {
            std::string& text = tasks.emplace_back();
            for (const std::string& stage : task.stages)
                if (const std::size_t at = stage.find('@'); at != std::string::npos)
                    if (const std::string place = stage.substr(at + 1) + ";"; !text.ends_with(";" + place) && text != place)
                        text += place;
        }
    return tasks;
}

}  // namespace

TEST_CASE("stages with the same axes on the same kind of machine are a group, one combination after the other", "[tasks]")
{
    const Loaded loaded(painting(2, 2));
    const Value table = to_value(make_task_table(loaded.pipeline(), loaded.all(), loaded.each(10), {0, 4}));
    CHECK(table.at("groups") == fresco::parse_json(R"([
        {"name": "once", "axes": [], "gpu": false, "stages": ["legend"], "needs": [],
         "first": 0, "count": 1, "seconds": 10.3, "memory_mb": 100.0, "threads": 4},
        {"name": "scan", "axes": ["scan"], "gpu": false, "stages": ["scan_of", "mesh"], "needs": [],
         "first": 1, "count": 2, "seconds": 20.6, "memory_mb": 100.0, "threads": 4},
        {"name": "scan,picture-gpu", "axes": ["scan", "picture"], "gpu": true, "stages": ["paint"], "needs": [1],
         "first": 3, "count": 4, "seconds": 10.3, "memory_mb": 100.0, "threads": 4},
        {"name": "scan,picture-2", "axes": ["scan", "picture"], "gpu": false, "stages": ["bake"], "needs": [2],
         "first": 7, "count": 4, "seconds": 10.3, "memory_mb": 100.0, "threads": 4}])"));
    const Value::List& tasks = table.at("tasks").as_list();
    REQUIRE(tasks.size() == 11);
    CHECK(tasks[2].at("stages") == Value::List{"scan_of@s1", "mesh@s1"});
    CHECK(tasks[6] ==
          fresco::parse_json(R"({"id": 6, "group": 2, "axes": {"scan": "s1", "picture": "p1"}, "stages": ["paint@s1,p1"],
                                             "needs": [2], "seconds": 10.3, "memory_mb": 100.0})"));
    CHECK(tasks[10].at("needs") == Value::List{6});
    CHECK(table.at("axes").as_list()[1].at("labels") == Value::List{"p0", "p1"});
}

TEST_CASE("neighbors of one scan are packed first, and no scan waits for another's preparation", "[tasks]")
{
    const Loaded loaded(painting(2, 4));
    const TaskTable table = make_task_table(loaded.pipeline(), loaded.all(), loaded.each(10), {21, 1});
    CHECK(packed(table, 1) == Words{"s0;", "s1;"});
    CHECK(packed(table, 2) == Words{"s0,p0;s0,p1;", "s0,p2;s0,p3;", "s1,p0;s1,p1;", "s1,p2;s1,p3;"});
    CHECK(table.tasks[3].axes == std::vector<std::pair<std::string, std::string>>{{"scan", "s0"}});
    CHECK(make_task_table(loaded.pipeline(), std::vector<bool>(loaded.all().size()), {}, {}).tasks.empty());
}

TEST_CASE("packing is what its rule says, for random times", "[tasks]")
{
    std::mt19937 random(7);
    const auto number = [&](int least, int most)
    { return least + static_cast<int>(random() % static_cast<unsigned>(most - least + 1)); };
    for (int round = 0; round < 40; ++round)
    {
        const Loaded loaded(painting(number(1, 5), number(1, 6)));
        std::map<std::string, CostFigures> estimates;
        std::vector<bool> runs;
        for (const PipelineStage& stage : loaded.pipeline().stages)
        {
            estimates[stage.name] = {static_cast<double>(number(0, 30)), 1, 1};
            runs.push_back(number(0, 9) > 0);
        }
        const double limit = number(0, 120);
        const TaskTable table = make_task_table(loaded.pipeline(), runs, estimates, {limit, 1});
        INFO("round " << round << ", limit " << limit);
        std::map<std::string, std::size_t> owners;
        for (const Task& task : table.tasks)
            for (const std::string& stage : task.stages)
                CHECK(owners.emplace(stage, task.id).second);
        for (std::size_t i = 0; i < runs.size(); ++i)
        {
            const PipelineStage& stage = loaded.pipeline().stages[i];
            REQUIRE(owners.contains(stage.name) == runs[i]);
            if (!runs[i])
                continue;
            const Task& task = table.tasks[owners.at(stage.name)];
            for (const Wire& wire : stage.wires)
                if (const auto maker = owners.find(wire.from_stage); maker != owners.end() && maker->second != task.id)
                {
                    CHECK(maker->second < task.id);
                    CHECK(std::binary_search(task.needs.begin(), task.needs.end(), maker->second));
                }
        }
        for (std::size_t group = 0; group < table.groups.size(); ++group)
            if (!table.groups[group].axes.empty())
                CHECK(packed(table, group) == packed_slowly(loaded, table, group, estimates, limit));
    }
}

TEST_CASE("a table keeps the command line's settings and what auto devices stand for where it is made", "[tasks]")
{
    const auto sets_of = [](const std::string& device, const std::string& matrix)
    {
        const Loaded loaded("version: 1\nvars: {where: cpu}\n" + matrix + R"(
stages:
  mesh: {type: mesh.pass}
  paint: {type: paint, input: mesh, device: )" +
                            device + "}\n");
        const PipelineRequest request{"p.yaml", {{"mesh.size", "2"}}, loaded.folder.path()};
        return plan_tasks(request, loaded.pipeline(), loaded.folder.path() / "store", loaded.folder.path() / "out", {})
            .pipeline.sets;
    };
    CHECK(sets_of("auto", "") == Sets{{"mesh.size", "2"}, {"paint.device", "cpu"}});
    CHECK(sets_of("cuda", "") == Sets{{"mesh.size", "2"}, {"paint.device", "cuda"}});
    // Of an axis: it is in the file.
    CHECK(sets_of("\"${where}\"", "matrix: {where: [cpu, cuda]}") == Sets{{"mesh.size", "2"}});
}

TEST_CASE("a table is read back as it was written, one chunk at a time", "[tasks]")
{
    const Loaded loaded(painting(3, 4));
    TaskTable table = small_table(loaded);
    table.store = "/store";
    table.out = "/out";
    table.chunk_size = 5;
    const auto folder = loaded.folder.path() / "tasks";
    write_task_table(table, folder);
    const TaskTable again = read_task_table(folder);
    CHECK(to_value(again) == to_value(table));
    CHECK(again.pipeline.texts.at(0).text == table.pipeline.texts.at(0).text);
    const TaskTable head = read_task_head(folder);
    CHECK(head.tasks.empty());
    // Only its own chunk is looked at.
    std::filesystem::remove(folder / "tasks" / "000000.json");
    CHECK(read_task(folder, head, 7).stages == table.tasks[7].stages);
    CHECK_THROWS_AS(read_task(folder, head, 4), fresco::MissingInput);
    CHECK_THROWS_WITH(read_task(folder, head, 99), Catch::Contains("no task 99: there are 0 to 27"));
    CHECK_THROWS_WITH(write_task_table(table, folder), Catch::Contains("already holds tasks"));
    CHECK_THROWS_AS(read_task_head(loaded.folder.path()), fresco::MissingInput);
}

TEST_CASE("a damaged table is refused, naming the file and the place", "[tasks]")
{
    const Loaded loaded(painting(1, 2));
    const TaskTable table = small_table(loaded);
    const auto folder = loaded.folder.path() / "tasks";
    write_task_table(table, folder);
    for (const auto& [file, what, with, problem] : std::vector<std::array<std::string, 4>>{
             {"tasks.json", "\"version\": 1", "\"version\": 2", ": version: expected an integer from 1 to 1, got 2"},
             {"tasks.json", "\"task_count\": 6", "\"task_count\": 5", ": groups[3].count: "},
             {"tasks.json", "\"task_count\": 6", "\"task_count\": 7", ": groups: they have 6 tasks, expected 7"},
             {"tasks.json", "\"gpu\": true", "\"gpu\": 1", ": groups[2].gpu: expected true or false"},
             {"tasks.json", "\"store\"", "\"stores\"", ": unknown entry 'stores'"},
             {"tasks.json", "\"threads\": 2", "\"threads\": 0", ": groups[0].threads: expected an integer from 1"},
             {"tasks.json", "\"hash\": \"00\"", "\"hash\": 0", ": plugins.paint.hash: expected a text"},
             {"tasks/000000.json", "\"needs\":[1]", "\"needs\":[2]", ": tasks[2].needs[0]: expected an integer from 0 to 1"},
             {"tasks/000000.json", "\"id\":0", "\"id\":1", ": tasks[0].id: expected an integer from 0 to 0"},
             {"tasks/000000.json", "\"stages\":[\"legend\"]", "\"stages\":[]", ": tasks[0].stages: "},
             {"tasks/000000.json", "\"seconds\":1.3", "\"seconds\":-1", ": tasks[0].seconds: expected a number from 0"},
             {"tasks/000000.json", "]}", "", ":"},
             {"pipeline/0-p.yaml", "legend", "Legend", ": was edited; change "}})
    {
        const std::string good = fresco::read_text_file(folder / file);
        std::string bad = good;
        bad.replace(good.find(what), what.size(), with);
        fresco::write_file(folder / file, std::string_view(bad));
        CHECK_THROWS_WITH(read_task_table(folder), Catch::StartsWith((folder / file).string() + problem));
        fresco::write_file(folder / file, std::string_view(good));
    }
}
