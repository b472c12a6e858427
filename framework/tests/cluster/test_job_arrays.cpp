#include "catch.h"
#include "cluster/job_arrays.h"
#include "cluster/submit.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <fmt/format.h>

namespace
{

using namespace fresco::host;

QueuedTask task(std::size_t number, const std::string& group, std::vector<std::size_t> needs = {})
{
    return {number, group, fmt::format("{}@{}", group, number), std::move(needs), 10, 500, 1, false};
}

/// For each task of a submission that can run, the tasks that the scheduler makes it wait for.
std::map<std::size_t, std::set<std::size_t>> told(const std::vector<JobArray>& arrays)
{
    std::map<std::string, std::map<std::size_t, std::size_t>> tasks;
    std::map<std::size_t, std::set<std::size_t>> result;
    for (const JobArray& array : arrays)
    {
        for (const ArrayElement& element : array.elements)
        {
            CHECK(tasks[array.name].emplace(element.index, element.task).second);
            auto& waits = result[element.task];
            for (const ArrayDependency& dependency : array.dependencies)
            {
                const auto& other = tasks.at(dependency.array);
                if (dependency.corresponding)
                    waits.insert(other.at(element.index));
                else if (dependency.elements.empty())
                    for (const auto& [index, number] : other)
                        waits.insert(number);
                for (const std::size_t index : dependency.elements)
                    waits.insert(other.at(index));
            }
        }
    }
    return result;
}

void check_exact(const std::vector<QueuedTask>& tasks, const std::vector<JobArray>& arrays)
{
    const auto waits = told(arrays);
    REQUIRE(waits.size() == tasks.size());
    for (const QueuedTask& one : tasks)
        CHECK(waits.at(one.number) == std::set<std::size_t>(one.needs.begin(), one.needs.end()));
}

}  // namespace

TEST_CASE("a task waits for exactly what it needs, in few arrays")
{
    std::vector<QueuedTask> tasks;
    SECTION("pictures of scans: an array per scan")
    {
        for (std::size_t scan = 0; scan < 5; ++scan)
            tasks.push_back(task(tasks.size(), "scan"));
        for (std::size_t scan = 0; scan < 5; ++scan)
            for (int picture = 0; picture < 20; ++picture)
                tasks.push_back(task(tasks.size(), "scan+picture", {scan}));
        const auto arrays = job_arrays(tasks, {}, 1001);
        CHECK(arrays.size() == 6);
        check_exact(tasks, arrays);
    }
    SECTION("a preparation of its own for each: two arrays")
    {
        for (int i = 0; i < 30; ++i)
            tasks.push_back(task(tasks.size(), "scan"));
        for (std::size_t i = 0; i < 30; ++i)
            tasks.push_back(task(tasks.size(), "paint", {29 - i}));
        const auto arrays = job_arrays(tasks, {}, 1001);
        REQUIRE(arrays.size() == 2);
        CHECK(arrays[1].dependencies.at(0).corresponding);
        check_exact(tasks, arrays);
    }
    SECTION("scans and pictures that are both prepared: an array per scan, whose elements follow the pictures")
    {
        for (int i = 0; i < 3; ++i)
            tasks.push_back(task(tasks.size(), "scan"));
        for (int i = 0; i < 8; ++i)
            tasks.push_back(task(tasks.size(), "picture"));
        for (std::size_t scan = 0; scan < 3; ++scan)
            for (std::size_t picture = 0; picture < 8; ++picture)
                tasks.push_back(task(tasks.size(), "paint", {scan, 3 + picture}));
        const auto arrays = job_arrays(tasks, {}, 1001);
        CHECK(arrays.size() == 5);
        check_exact(tasks, arrays);
    }
    SECTION("one that needs all others, and no index beyond the largest")
    {
        for (int i = 0; i < 25; ++i)
            tasks.push_back(task(tasks.size(), "scan"));
        std::vector<std::size_t> all(25);
        for (std::size_t i = 0; i < 25; ++i)
            all[i] = i;
        tasks.push_back(task(25, "once", all));
        const auto arrays = job_arrays(tasks, {}, 10);
        REQUIRE(arrays.size() == 4);
        CHECK(arrays[3].dependencies.size() == 3);
        CHECK(arrays[3].dependencies[0].elements.empty());
        for (const auto& array : arrays)
            for (const auto& element : array.elements)
                CHECK(element.index < 10);
        check_exact(tasks, arrays);
    }
    SECTION("tasks with other limits are in arrays of their own")
    {
        for (int i = 0; i < 4; ++i)
            tasks.push_back(task(tasks.size(), "scan"));
        tasks[2].memory_mb = 1000;
        const auto arrays = job_arrays(tasks, {}, 1001);
        REQUIRE(arrays.size() == 2);
        CHECK(arrays[0].memory_mb == 500);
        CHECK(arrays[0].elements.size() == 3);
        CHECK(arrays[1].memory_mb == 1000);
    }
}

TEST_CASE("a task follows one that is in the queue already, and does not wait for one that is done")
{
    const auto arrays = job_arrays({task(5, "paint", {0, 1}), task(6, "paint", {2})}, {{1, {"77", 4, true}}}, 1001);
    REQUIRE(arrays.size() == 2);
    REQUIRE(arrays[0].dependencies.size() == 1);
    CHECK(arrays[0].dependencies[0].array == "77");
    CHECK(arrays[0].dependencies[0].queued_before);
    CHECK(arrays[1].dependencies.empty());
    CHECK(arrays[1].elements.at(0).task == 6);
}

TEST_CASE("indices are written as ranges")
{
    CHECK(index_ranges({{0, 0, ""}, {1, 0, ""}, {2, 0, ""}, {5, 0, ""}, {7, 0, ""}, {8, 0, ""}}) == "0-2,5,7-8");
    CHECK(index_ranges({{3, 0, ""}}) == "3");
}

TEST_CASE("what is missing is queued in the order of its needs, as much as there is room for")
{
    const fresco::testing::TemporaryFolder folder;
    TaskTable table;
    table.groups = {{"scan", {"scan"}, false, {"mesh"}, {}, 0, 2, 100, 1000, 4},
                    {"scan,picture", {"scan", "picture"}, true, {"texture"}, {0}, 2, 4, 1200, 100, 2}};
    table.tasks = {{0, 0, {"mesh@a"}, {{"scan", "a"}}, {}, 100, 1000},
                   {1, 0, {"mesh@b"}, {{"scan", "b"}}, {}, 100, 1000},
                   {2, 1, {"texture@a,x"}, {{"scan", "a"}, {"picture", "x"}}, {0}, 1200, 100},
                   {3, 1, {"texture@a,y"}, {{"scan", "a"}, {"picture", "y"}}, {0}, 1200, 100},
                   {4, 1, {"texture@b,x"}, {{"scan", "b"}, {"picture", "x"}}, {1}, 1200, 100},
                   {5, 1, {"texture@b,y", "texture@b,z"}, {{"scan", "b"}}, {1}, 1200, 100}};
    TaskKnowledge known;
    known.done.resize(6);
    const auto numbers = [](const MissingTasks& missing)
    {
        std::vector<std::size_t> result;
        for (const auto& one : missing.tasks)
            result.push_back(one.number);
        return result;
    };

    const auto all = missing_tasks(table, known, folder.path(), 1, 100);
    CHECK(numbers(all) == std::vector<std::size_t>{0, 1, 2, 3, 4, 5});
    CHECK(all.tasks[0].name == "scan@a");
    CHECK(all.tasks[0].minutes == 5);
    CHECK(all.tasks[0].memory_mb == 1300);
    CHECK(all.tasks[0].threads == 4);
    CHECK(all.tasks[2].group == "scan+picture");
    CHECK(all.tasks[2].minutes == 40);
    CHECK(all.tasks[2].memory_mb == 500);
    CHECK(all.tasks[2].gpu);
    CHECK(all.tasks[5].name == "scan,picture@b.5");

    const auto some = missing_tasks(table, known, folder.path(), 1, 3);
    CHECK(numbers(some) == std::vector<std::size_t>{0, 1, 2});
    CHECK(some.left == 3);

    // a is done, b failed in this round: what needs it is not queued.
    known.done[0] = true;
    known.attempts[0] = {{{"7", 0}, 0, 1, 5, 1300}};
    known.attempts[1] = {{{"7", 1}, 0, 1, 5, 1300}};
    const auto rest = missing_tasks(table, known, folder.path(), 1, 100);
    CHECK(numbers(rest) == std::vector<std::size_t>{2, 3});
    CHECK(rest.blocked == 3);

    // Asked for again, it is queued again; with more memory where that ran out.
    CHECK(numbers(missing_tasks(table, known, folder.path(), 2, 100)) == std::vector<std::size_t>{1, 2, 3, 4, 5});
    std::filesystem::create_directory(folder.path() / "logs");
    fresco::write_file(folder.path() / "logs" / "scan@b.log",
                       "== task 1 (scan@b), job 7_1 on n, start 1\nslurmstepd: error: Detected 1 "
                       "oom-kill event(s) in step 7.batch\n");
    CHECK(missing_tasks(table, known, folder.path(), 2, 100).tasks.at(0).memory_mb == 2600);

    // Still in the queue: others wait for it there.
    known.queue.elements[{"7", 1}] = "RUNNING";
    const auto beside = missing_tasks(table, known, folder.path(), 2, 100);
    CHECK(numbers(beside) == std::vector<std::size_t>{2, 3, 4, 5});
    CHECK(beside.queued.at(1) == ElementPlace{"7", 1, true});
}

TEST_CASE("the scheduler's answers are read")
{
    const SlurmLimits limits = limits_in("MaxArraySize            = 101\nMaxJobCount             = 5000\nMaxJobId = 67043328\n");
    CHECK(limits.array_size == 101);
    CHECK(limits.job_count == 5000);
    CHECK(limits_in("").array_size == 1001);
    const SlurmQueue queue = queue_in("12 0 RUNNING fresco-1.0.scan-0\n12 1 PENDING fresco-1.0.scan-0\n13 N/A PENDING "
                                      "fresco-1.0.continue\n14 0 RUNNING fresco-12.0.scan-0\n",
                                      "fresco-1");
    CHECK(queue.elements.size() == 2);
    CHECK(queue.elements.at({"12", 1}) == "PENDING");
    CHECK(queue.jobs.at("fresco-1.0.continue") == "13");
    CHECK(queue.jobs.size() == 2);
}
