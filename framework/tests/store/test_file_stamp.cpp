#include "store_samples.h"

#include "base/common.h"
#include "base/file_stamp.h"
#include "base/records.h"
#include "store/statistics.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <sys/statfs.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <thread>
#include <unistd.h>

using namespace fresco::host;
using fresco::Value;
using fresco::testing::TemporaryFolder;

namespace
{

constexpr std::int64_t ext4 = 0xEF53;
constexpr std::int64_t squashfs = 0x73717368;
/// Set: files seem to be on a file system of this type.
std::int64_t pretended_type = 0;

/// A thread asks for the file system again.
void on(std::int64_t type, const std::function<void()>& action)
{
    pretended_type = type;
    std::thread(action).join();
    pretended_type = 0;
}

}  // namespace

/// In place of the C library's.
extern "C" int statfs(const char* path, struct statfs* status) noexcept
{
    const auto result = static_cast<int>(syscall(SYS_statfs, path, status));
    if (pretended_type != 0)
        status->f_type = pretended_type;
    return result;
}

TEST_CASE("A stamp is relied on only where the file system keeps the time of the last change")
{
    constexpr std::int64_t second = 1'000'000'000;
    constexpr std::int64_t nfs = 0x6969;
    constexpr std::int64_t fuse = 0x65735546;
    constexpr std::int64_t fat = 0x4D44;
    struct Row
    {
        std::int64_t type, mtime_ns, ctime_ns;
        bool read_only, relied_on;
    };
    for (const Row& row :
         std::vector<Row>{{ext4, 5 * second, 5 * second, false, true},
                          {ext4, 5 * second, 5 * second, true, false},         // An image.
                          {ext4, 5 * second, 9 * second, true, false},         // Made in that second, as another may be.
                          {ext4, 5 * second + 1, 9 * second + 1, true, true},  // Written when it was mounted for writing.
                          {squashfs, 5 * second, 5 * second, false, false},
                          {fat, 5 * second, 5 * second, false, false},
                          {fuse, 5 * second + 1, 5 * second + 1, false, false},
                          {nfs, 5 * second + 1, 5 * second + 1, false, false},
                          {nfs, 5 * second, 9 * second + 1, false, true},
                          {0, 5 * second + 1, 5 * second + 1, false, false}})  // It did not answer.
    {
        CAPTURE(row.type, row.mtime_ns, row.ctime_ns, row.read_only);
        FileStamp stamp;
        stamp.mtime_ns = row.mtime_ns;
        stamp.ctime_ns = row.ctime_ns;
        stamp.file_system = row.type;
        CHECK(tells_changes(stamp, row.read_only) == row.relied_on);
    }
}

TEST_CASE("In an image, contents count whatever the stamp says")
{
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    write(input, "one");  // Both its times are now.
    let_stamps_settle();
    Dependency dependency;
    on(ext4, [&] { dependency = take_dependency(input, false); });
    REQUIRE(dependency.stamp);
    FileHashes hashes(folder.path() / "files.jsonl");
    on(squashfs,
       [&]
       {
           CHECK(!take_dependency(input, false).stamp);
           hashes.hash(input);
           hashes.save();
           CHECK(!fs::exists(folder.path() / "files.jsonl"));
           // Nor is the stamp relied on that another file system left under the same number.
           dependency.stamp = stamp_of(input);
           dependency.hash = "of another image";
           CHECK(compare(dependency) == Change::contents);
       });
}

TEST_CASE("A renewed stamp saves reading the contents the next time")
{
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    write(input, "one");
    // Changed a moment ago: no stamp is believed.
    Dependency dependency = take_dependency(input, false);
    CHECK(!dependency.stamp);
    CHECK(compare(dependency) == Change::none);
    touch(input, 2);
    CHECK(!take_dependency(input, false).stamp);
    let_stamps_settle();
    CHECK(compare(dependency) == Change::stamp);
    CHECK(dependency.stamp);
    CHECK(compare(dependency) == Change::none);
    // Other bytes of the same number, with the times that the file had before.
    const std::string before = FileHashes({}).hash(input);
    const auto time = fs::last_write_time(input);
    std::fstream(input, std::ios::in | std::ios::out) << "owt";
    fs::last_write_time(input, time);
    CHECK(compare(dependency) == Change::contents);
    CHECK(FileHashes({}).hash(input) != before);
}

TEST_CASE("Remembered hashes are kept beyond the process only in an index that is whole")
{
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    const fs::path index = folder.path() / "files.jsonl";
    write(input, "one");
    touch(input, 2);  // A time of its own, as a container's file system is not trusted.
    let_stamps_settle();
    FileHashes first(index);
    const std::string hash = first.hash(input);
    first.save();
    const std::string text = fresco::read_text_file(index);
    REQUIRE(text.find(hash) != std::string::npos);
    std::string flipped = text;
    flipped[flipped.find(hash)] = flipped[flipped.find(hash)] == '0' ? '1' : '0';
    write(index, flipped);
    CHECK(FileHashes(index).hash(input) == hash);

    // Whole lines of another form, as another version of fresco may write them.
    Journal(index).add(Value::Map{{"files", Value::List{Value::List{"input", false, Value()}, 7, Value::List{1, 2, 3, 4}}}});
    CHECK(FileHashes(index).hash(input) == hash);

    FileHashes nowhere({});
    CHECK(nowhere.hash(input) == hash);
    nowhere.save();
    CHECK(names_in(folder.path()) == std::vector<std::string>{"files.jsonl", "input"});
}

TEST_CASE("A folder's dependency is its names that match the pattern")
{
    const TemporaryFolder folder;
    write(folder.path() / "seq-01", "1");
    Dependency sequences = take_dependency(folder.path() / "seq-*", true);
    Dependency calibration = take_dependency(folder.path() / "k.txt", true);
    fs::create_directory(folder.path() / "out");
    write(folder.path() / "seq-01", "2");
    CHECK(compare(sequences) == Change::none);
    CHECK(compare(calibration) == Change::none);
    write(folder.path() / "k.txt", "1");
    CHECK(compare(sequences) != Change::contents);
    CHECK(compare(calibration) == Change::contents);
    fs::rename(folder.path() / "seq-01", folder.path() / "seq-02");
    CHECK(compare(sequences) == Change::contents);
    fs::rename(folder.path() / "seq-02", folder.path() / "seq-01");
    CHECK(compare(sequences) == Change::none);
    CHECK_THROWS_AS(take_dependency(folder.path() / "nowhere" / "*", true), fresco::MissingInput);
}

TEST_CASE("A line that was cut takes no other with it")
{
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "journal";
    const Journal journal(file);
    const auto add = [&](int number) { journal.add(Value::Map{{"number", number}}); };
    const auto numbers = [&] { return each(journal.read(), [](const Value& map) { return map.at("number").as_int(); }); };
    using Numbers = std::vector<std::int64_t>;
    for (int i = 0; i < 3; ++i)
        add(i);
    const std::string whole = fresco::read_text_file(file);
    for (std::size_t size = whole.size() * 2 / 3 + 1; size <= whole.size(); size += 5)
    {
        write(file, whole.substr(0, size));
        add(7);
        const Numbers found = numbers();
        REQUIRE(found.size() >= 3);
        CHECK(Numbers{found[0], found[1], found.back()} == Numbers{0, 1, 7});
    }
    std::string flipped = whole;
    flipped[flipped.find(":1") + 1] = '5';
    write(file, flipped);
    CHECK(numbers() == Numbers{0, 2});
    journal.replace({Value::Map{{"number", 9}}});
    CHECK(numbers() == Numbers{9});
}

TEST_CASE("Figures that many tasks measure at once are all kept until they are tidied up")
{
    const OwnStore store;
    const auto add = [&](const std::string& type, const std::string& options, double seconds, double memory_mb) {
        Statistics(store).add({type, options}, {seconds, memory_mb, 3});
    };
    const auto seconds = [&](const std::string& type, const std::string& options) {
        return Statistics(store).last({type, options}).value_or(Usage{}).seconds;
    };
    const auto has = [&](const std::string& options) { return Statistics(store).last_with_options({"t.often", options}); };
    in_processes(4,
                 [&](int process)
                 {
                     for (int i = 0; i < 5; ++i)
                         add("t." + std::to_string(5 * process + i), "a", 1.0 + i, 2);
                 });
    for (int i = 0; i < 20; ++i)
        CHECK(seconds("t." + std::to_string(i), "a") == 1.0 + i % 5);
    for (int i = 0; i < 20; ++i)
        add("t.often", "a", i, 30.0 - i);
    const auto size = fs::file_size(store.root() / "stats.jsonl");
    for (const bool tidied : {false, true})
    {
        CHECK(seconds("t.often", "a") == 15.5);
        CHECK(Statistics(store).last({"t.often", "a"}).value().memory_mb == 18);
        CHECK((fs::file_size(store.root() / "stats.jsonl") < size) == tidied);
        Statistics(store).tidy();
    }
    CHECK(seconds("t.7", "a") == 3);
    // Runs with the same options say more than others of the type, and are kept beside them.
    add("t.often", "b", 100, 5);
    CHECK(seconds("t.often", "b") == 100);
    CHECK(seconds("t.often", "a") == 15.5);
    CHECK(seconds("t.often", "c") == 16);
    CHECK_FALSE(has("c"));
    for (int i = 0; i < 100; ++i)
        add("t.often", std::to_string(i), 1, 1);
    CHECK((has("36") && !has("35") && !has("a")));
    CHECK_FALSE(Statistics(store).last({"t.never", "a"}));
}

TEST_CASE("A record is refused at every length but its own, with every byte changed, and with anything added")
{
    const TemporaryFolder folder;
    const auto file = folder.path() / "record.json";
    write_record(file, Value::Map{{"stage", "mesh"}, {"sizes", Value::List{1, 2.5, true, Value()}}});
    CHECK(read_record(file).at("sizes").as_list().size() == 4);
    const std::string whole = fresco::read_text_file(file);
    const auto refused = [&](const std::string& text)
    {
        fresco::write_file(file, text);
        CHECK_THROWS_AS(read_record(file), fresco::Error);
    };
    for (std::size_t at = 0; at < whole.size(); ++at)
    {
        refused(whole.substr(0, at));
        for (const int change : {1, 32, 128, 255})
        {
            std::string text = whole;
            text[at] = static_cast<char>(text[at] ^ change);
            refused(text);
        }
    }
    for (const char more : {'\n', ' ', '}', '\0'})
        refused(whole + more);
}
