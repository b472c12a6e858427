#include "store_samples.h"

#include "base/records.h"
#include "store/statistics.h"
#include <fresco/error.h>

using namespace fresco::host;
using fresco::Value;
using fresco::testing::TemporaryFolder;

namespace
{

Value numbered(int number)
{
    return Value::Map{{"number", number}};
}

std::vector<std::int64_t> numbers(const Journal& journal)
{
    std::vector<std::int64_t> found;
    for (const Value& map : journal.read())
        found.push_back(map.at("number").as_int());
    return found;
}

}  // namespace

TEST_CASE("Processes add to a journal at once, and no line is lost")
{
    const TemporaryFolder folder;
    const Journal journal(folder.path() / "journal");
    CHECK(journal.read().empty());
    in_processes(4,
                 [&](int process)
                 {
                     for (int i = 0; i < 50; ++i)
                         journal.add(numbered(100 * process + i));
                 });
    const auto found = numbers(journal);
    CHECK(std::set<std::int64_t>(found.begin(), found.end()).size() == 200);
    CHECK(found.size() == 200);
}

TEST_CASE("A line that was cut takes no other with it")
{
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "journal";
    const Journal journal(file);
    for (int i = 0; i < 3; ++i)
        journal.add(numbered(i));
    const std::string whole = fresco::read_text_file(file);
    for (std::size_t size = whole.size() * 2 / 3 + 1; size <= whole.size(); size += 5)
    {
        write(file, whole.substr(0, size));
        journal.add(numbered(7));
        const auto found = numbers(journal);
        CHECK(found.size() >= 3);
        CHECK(found.front() == 0);
        CHECK(found[1] == 1);
        CHECK(found.back() == 7);
    }
    std::string flipped = whole;
    flipped[flipped.find(":1") + 1] = '5';
    write(file, flipped);
    CHECK(numbers(journal) == std::vector<std::int64_t>{0, 2});
    journal.replace({numbered(9)});
    CHECK(numbers(journal) == std::vector<std::int64_t>{9});
}

TEST_CASE("Costs that many tasks measure at once are all kept until they are tidied up")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    in_processes(4,
                 [&](int process)
                 {
                     for (int i = 0; i < 5; ++i)
                         record_cost(store, "t." + std::to_string(5 * process + i), {1.0 + i, 2, 3}, {});
                 });
    for (int i = 0; i < 20; ++i)
        CHECK(Statistics(store).knows("t." + std::to_string(i)));
    for (int i = 0; i < 20; ++i)
        record_cost(store, "t.often", {static_cast<double>(i), 2, 3}, {});
    CHECK(Statistics(store).corrected("t.often", {}).seconds == 15.5);
    const auto size = fs::file_size(store.root() / "stats.jsonl");
    tidy_costs(store);
    CHECK(fs::file_size(store.root() / "stats.jsonl") < size);
    CHECK(Statistics(store).corrected("t.often", {}).seconds == 15.5);
    CHECK(Statistics(store).knows("t.7"));
}
