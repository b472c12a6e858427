#include "store_samples.h"

#include "base/file_stamp.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/hash.h>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

namespace
{

/// Other bytes of the same number, with the times that the file had before.
void write_in_secret(const fs::path& file, const std::string& text)
{
    const auto time = fs::last_write_time(file);
    std::fstream(file, std::ios::in | std::ios::out) << text;
    fs::last_write_time(file, time);
}

}  // namespace

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
    write(input, "owt");
    CHECK(compare(dependency) == Change::contents);
}

TEST_CASE("Other bytes are seen, whatever size and times the file has")
{
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    write(input, "one");
    write(folder.path() / "copy", "owt");
    touch(input, 3);
    fs::last_write_time(folder.path() / "copy", fs::last_write_time(input));
    let_stamps_settle();
    Dependency dependency = take_dependency(input, false);
    REQUIRE(dependency.stamp);
    FileHashes hashes({});
    const std::string before = hashes.hash(input);
    SECTION("written in place")
    {
        write_in_secret(input, "two");
    }
    SECTION("another file in its place")
    {
        fs::rename(folder.path() / "copy", input);
    }
    SECTION("through a link that leads elsewhere now")
    {
        fs::remove(input);
        fs::create_symlink(folder.path() / "copy", input);
    }
    CHECK(compare(dependency) == Change::contents);
    CHECK(hashes.hash(input) != before);
}

TEST_CASE("Remembered hashes are kept beyond the process only in an index that is whole")
{
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    const fs::path index = folder.path() / "files.jsonl";
    write(input, "one");
    let_stamps_settle();
    FileHashes first(index);
    const std::string hash = first.hash(input);
    // A path that cannot be looked at any more is nobody's business.
    const fs::path elsewhere = folder.path() / "elsewhere";
    write(elsewhere / "file", "1");
    first.hash(elsewhere / "file");
    fs::remove_all(elsewhere);
    fs::create_symlink(elsewhere, elsewhere);
    first.save();
    fs::remove(elsewhere);
    const std::string text = fresco::read_text_file(index);
    REQUIRE(text.find(hash) != std::string::npos);
    std::string flipped = text;
    flipped[flipped.find(hash)] = flipped[flipped.find(hash)] == '0' ? '1' : '0';
    write(index, flipped);
    CHECK(FileHashes(index).hash(input) == hash);

    // Whole lines of another form, as another version of fresco may write them.
    using fresco::Value;
    Journal(index).add(Value::Map{{"files", Value::List{Value::List{"input", false, Value()}, 7, Value::List{1, 2, 3, 4}}}});
    CHECK(FileHashes(index).hash(input) == hash);

    FileHashes nowhere({});
    CHECK(nowhere.hash(input) == hash);
    nowhere.save();
    CHECK(names_in(folder.path()) == std::vector<std::string>{"files.jsonl", "input"});
}

TEST_CASE("A folder's dependency is its names")
{
    const TemporaryFolder folder;
    const fs::path inner = folder.path() / "inner";
    write(inner / "a", "1");
    Dependency dependency = take_dependency(inner / "*", true);
    write(inner / "a", "2");
    CHECK(compare(dependency) == Change::none);
    write(inner / "b", "1");
    CHECK(compare(dependency) == Change::contents);
}

TEST_CASE("Of a folder's names only those count that match the pattern")
{
    const TemporaryFolder folder;
    write(folder.path() / "seq-01", "1");
    Dependency sequences = take_dependency(folder.path() / "seq-*", true);
    Dependency calibration = take_dependency(folder.path() / "k.txt", true);
    fs::create_directory(folder.path() / "out");
    write(folder.path() / ".DS_Store", "1");
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
