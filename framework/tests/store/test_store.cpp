#include "program.h"

#include "store/publish.h"
#include "store/stage_record.h"
#include "store/store.h"
#include "store/store_tidy.h"
#include <fresco/checked_file.h>
#include <fresco/error.h>
#include <fresco/hash.h>

#include <algorithm>

#include <sys/stat.h>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

namespace
{

void write(const fs::path& file, const std::string& text)
{
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

StoredResult publish_text(const Store& store, const std::string& key, const std::string& text,
                          const std::vector<Dependency>& dependencies = {}, const std::set<std::string>& references = {})
{
    const fs::path folder = store.make_temporary();
    write(folder / "out" / "a.json", text);
    return publish(store, folder,
                   {key, {"out"}, dependencies, fresco::Value::Map{{"stage", "s"}, {"type", "t.t"}, {"time_s", 0}}, references});
}

/// As `touch` does.
void touch(const fs::path& file, int hours_ago)
{
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(hours_ago));
}

/// Until stamps of what was written are relied on. Nobody can set the time of the last change.
void let_stamps_settle()
{
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
}

/// Other bytes of the same number, with the times that the file had before.
void write_in_secret(const fs::path& file, const std::string& text)
{
    const auto time = fs::last_write_time(file);
    std::fstream(file, std::ios::in | std::ios::out) << text;
    fs::last_write_time(file, time);
}

std::vector<std::string> names_in(const fs::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace

TEST_CASE("A published result is found by its key, whole, and damage to it is named")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    CHECK(!store.lookup("key"));
    const StoredResult result = publish_text(store, "key", "[1]");
    const auto found = store.lookup("key");
    REQUIRE(found);
    CHECK(found->object == result.object);
    CHECK(store.present(*found));
    CHECK(!store.verify(result.object, 2));
    CHECK(fs::is_empty(folder.path() / "tmp"));

    const fs::path file = store.object(result.object) / "out" / "a.json";
    SECTION("a flipped bit")
    {
        write(file, "[2]");
        CHECK(contains(store.verify(result.object, 2).value().text, "a.json"));
        CHECK(!store.verify(publish_text(store, "other", "[1]").object, 2));
    }
    SECTION("a cut file")
    {
        fs::resize_file(file, 1);
        CHECK(contains(store.verify(result.object, 2).value().text, "has 1 bytes, 3 were written"));
    }
    SECTION("a missing file")
    {
        fs::remove(file);
        CHECK(store.verify(result.object, 2));
    }
    SECTION("a changed manifest")
    {
        std::string text = fresco::read_text_file(store.manifest_file(result.object));
        text.replace(text.find("t.t"), 3, "u.u");
        write(store.manifest_file(result.object), text);
        CHECK(contains(store.verify(result.object, 2).value().text, "checksum"));
    }
    SECTION("an output that the manifest does not list")
    {
        CHECK(contains(store.verify(result.object, 2, "other").value().text, "not among the files of the result"));
    }
    SECTION("an emptied manifest")
    {
        for (const char* text : {"", "{}", "{\"files\":[]}"})
        {
            write(store.manifest_file(result.object), text);
            CHECK(contains(store.verify(result.object, 2).value().text, "checksum"));
        }
        CHECK(publish_text(store, "key", "[1]").object == result.object);
        CHECK(!store.verify(result.object, 1));
    }
    SECTION("another result's folder")
    {
        const StoredResult other = publish_text(store, "other", "[2]");
        fs::rename(store.object(result.object), folder.path() / "aside");
        fs::rename(store.object(other.object), store.object(result.object));
        CHECK(contains(store.verify(result.object, 2, "out").value().text, "the manifest of another result"));
    }
    SECTION("a folder without a manifest is garbage and is replaced")
    {
        fs::remove(store.manifest_file(result.object));
        write(file, "half");
        CHECK(!store.present(*found));
        CHECK(publish_text(store, "key", "[1]").object == result.object);
        CHECK(!store.verify(result.object, 1));
    }
    SECTION("a removed result is not there any more")
    {
        store.discard(result.object);
        CHECK(!store.present(*store.lookup("key")));
        CHECK(fs::is_empty(folder.path() / "tmp"));
        CHECK(fs::is_empty(folder.path() / "objects"));
    }
}

TEST_CASE("Files of several pieces are verified piece by piece")
{
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "big";
    {
        std::ofstream stream(file, std::ios::binary);
        const std::string block(1U << 20U, 'x');
        for (int i = 0; i < 9; ++i)
            stream << block;
    }
    const StoredFile hashed = hash_chunks(folder.path(), "big");
    CHECK(hashed.size == 9U << 20U);
    REQUIRE(hashed.chunks.size() == 3);
    CHECK(hashed.chunks[0] == hashed.chunks[1]);
    CHECK(hashed.chunks[2] != hashed.chunks[1]);
    CHECK(!find_damage(folder.path(), hashed));
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(5 << 20);
    stream << 'y';
    stream.close();
    CHECK(contains(find_damage(folder.path(), hashed).value(), "from 4194304 on"));
    write(folder.path() / "empty", "");
    CHECK(hash_chunks(folder.path(), "empty").chunks.size() == 1);
    CHECK(!find_damage(folder.path(), hash_chunks(folder.path(), "empty")));
}

TEST_CASE("Outside files: touched is the same, changed is another, changed back is the first again")
{
    const TemporaryFolder folder;
    const Store store(folder.path() / "store");
    const fs::path input = folder.path() / "input";
    write(input, "one");
    const auto first = publish_text(store, "key", "[1]", {take_dependency(input, false)});
    touch(input, 1);
    CHECK(store.lookup("key").value().object == first.object);

    // Also where the new stamp cannot be written down: a folder is no lock.
    let_stamps_settle();
    fs::remove(store.lock_file("key"));
    fs::create_directory(store.lock_file("key"));
    CHECK(store.lookup("key").value().object == first.object);

    write(input, "two");
    std::string why;
    CHECK(!store.lookup("key", &why));
    CHECK(contains(why, input.string()));
    const auto second = publish_text(store, "key", "[2]", {take_dependency(input, false)});
    CHECK(second.object != first.object);
    CHECK(store.lookup("key").value().object == second.object);
    write(input, "one");
    CHECK(store.lookup("key").value().object == first.object);
    fs::remove(input);
    CHECK(!store.lookup("key"));
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
    const fs::path index = folder.path() / "files.json";
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

    FileHashes nowhere({});
    CHECK(nowhere.hash(input) == hash);
    nowhere.save();
    CHECK(names_in(folder.path()) == std::vector<std::string>{"files.json", "input"});
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

TEST_CASE("A key keeps its last eight results")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    for (int i = 0; i < 10; ++i)
        store.remember("key", {object_prefix("key") + std::to_string(i), {}, {}});
    CHECK(store.lookup("key").value().object == object_prefix("key") + "9");
    const auto record = fresco::parse_json(fresco::read_text_file(store.key_file("key")));
    CHECK(record.at("results").as_list().size() == 8);
}

TEST_CASE("Results refer to other results, and are there only if those are")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    const auto below = publish_text(store, "below", "[1]");
    const auto middle = publish_text(store, "middle", "[2]", {}, {below.object});
    CHECK(middle.references == std::vector<std::string>{below.object});
    const auto top = publish_text(store, "top", "[3]", {}, {middle.object});
    CHECK(top.references.size() == 2);
    CHECK(store.present(top));
    store.discard(below.object);
    CHECK(!store.present(top));
}

TEST_CASE("Text that looks like a path into the store is no reference")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    const fs::path temporary = store.make_temporary("run");
    write(temporary / "out" / "a.json",
          R"(["store:objects/0123456789abcdef0123456789abcdef/out", "tmp/)" + temporary.filename().string() + R"(/out"])");
    const auto result = publish(store, temporary, {"key", {"out"}, {}, fresco::Value::Map{}});
    CHECK(result.references.empty());
    CHECK(store.present(store.lookup("key").value()));
}

TEST_CASE("What cannot be stored is refused and nothing is published")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    const auto attempt = [&](const std::function<void(const fs::path&)>& make)
    {
        const fs::path temporary = store.make_temporary();
        fs::create_directories(temporary / "out");
        make(temporary);
        std::string text;
        try
        {
            publish(store, temporary, {"key", {"out"}, {}, fresco::Value::Map{}});
        }
        catch (const fresco::Error& error)
        {
            text = error.what();
        }
        CHECK(!store.lookup("key"));
        return text;
    };
    CHECK(contains(attempt([](const fs::path& at) { fs::create_symlink("/etc", at / "out" / "link"); }), "out/link"));
    CHECK(contains(attempt([](const fs::path& at) { mkfifo((at / "out" / "fifo").c_str(), 0600); }), "out/fifo"));
}

TEST_CASE("Names that a manifest cannot hold are refused")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    const fs::path temporary = store.make_temporary();
    write(temporary / "out" / "caf\xe9.txt", "1");
    CHECK_THROWS_WITH(publish(store, temporary, {"key", {"out"}, {}, fresco::Value::Map{}}),
                      Catch::Contains("caf\xe9.txt: the name is not UTF-8"));
    CHECK(!store.lookup("key"));
}

TEST_CASE("A store of another format is refused with both and with what to do")
{
    const TemporaryFolder folder;
    const fs::path format = folder.path() / "format";
    SECTION("a later one")
    {
        fresco::write_checked(format, "fresco store 7\n");
        CHECK_THROWS_WITH(Store(folder.path()), Catch::Contains("\"fresco store 7\"") && Catch::Contains("\"fresco store 2\"") &&
                                                    Catch::Contains("remove " + folder.path().string()));
    }
    SECTION("the first one")
    {
        write(format, "fresco store 1\n");
        CHECK_THROWS_WITH(Store(folder.path()), Catch::Contains("fresco store 1"));
    }
    SECTION("somebody else's file")
    {
        write(format, "A4");
        CHECK_THROWS_WITH(Store(folder.path()), Catch::Contains("format: is not the file of a store"));
        CHECK(names_in(folder.path()) == std::vector<std::string>{"format"});
    }
}

TEST_CASE("Damage to the format locks nobody out")
{
    const TemporaryFolder folder;
    const StoredResult result = publish_text(Store(folder.path()), "key", "[1]");
    const fs::path format = folder.path() / "format";
    const std::string whole = fresco::read_text_file(format);
    for (std::size_t at = 0; at < whole.size(); ++at)
    {
        std::string flipped = whole;
        flipped[at] = static_cast<char>(flipped[at] ^ 1);
        write(format, flipped);
        CHECK(Store(folder.path()).present(result));
        CHECK(fresco::read_text_file(format) == whole);
    }
    write(format, "");
    CHECK(Store(folder.path()).present(result));
    fs::remove(format);
    CHECK(Store(folder.path()).present(result));
    CHECK(fresco::read_text_file(format) == whole);
}

TEST_CASE("A lost or damaged record of a key is written again from the results")
{
    const TemporaryFolder folder;
    const Store store(folder.path() / "store");
    const fs::path input = folder.path() / "input";
    write(input, "one");
    const auto first = publish_text(store, "key", "[1]", {take_dependency(input, false)});
    write(input, "two");
    const auto second = publish_text(store, "key", "[2]", {take_dependency(input, false)});
    const auto other = publish_text(store, "other", "[3]");
    CHECK(!store.restore("key"));
    SECTION("lost")
    {
        fs::remove_all(store.root() / "keys");
    }
    SECTION("damaged")
    {
        write(store.key_file("key"), "{");
    }
    SECTION("another key's")
    {
        fs::rename(store.key_file("other"), store.key_file("key"));
    }
    const Store again(store.root());
    CHECK(!again.lookup("key"));
    CHECK(again.restore("key"));
    CHECK(again.lookup("key").value().object == second.object);
    write(input, "one");
    CHECK(again.lookup("key").value().object == first.object);
    again.restore("other");
    CHECK(again.lookup("other").value().object == other.object);
    CHECK(!again.restore("a key that led to nothing"));
}

TEST_CASE("What is published can be read by those whom the umask lets")
{
    const TemporaryFolder folder;
    const mode_t before = umask(022);
    const Store store(folder.path());
    const auto result = publish_text(store, "key", "[1]");
    umask(before);
    CHECK(fs::status(store.object(result.object)).permissions() == fs::perms(0755));
}

TEST_CASE("Tidying up keeps what is in use, and leaves nothing that serves nobody")
{
    const TemporaryFolder folder;
    const Store store(folder.path() / "store");
    const fs::path pipeline = folder.path() / "room.yaml";
    write(pipeline, "version: 1");
    write(folder.path() / "gone.yaml", "version: 1");
    const auto used = publish_text(store, "used", "[1]");
    const auto unused = publish_text(store, "unused", "[2]");
    write_stage_record(store, pipeline, {"s", "used", used.object, {}});
    write_stage_record(store, folder.path() / "gone.yaml", {"s", "unused", unused.object, {}});
    fs::remove(folder.path() / "gone.yaml");
    for (const char* key : {"used", "unused", "store"})
        FileLock(store.lock_file(key)).try_exclusive();
    write(store.root() / "keys" / ".fresco-0123", "left by a killed writer");
    const fs::path stages = store.root() / "stages";
    const auto records = [&] { return std::distance(fs::directory_iterator(stages), {}); };
    REQUIRE(records() == 2);

    SECTION("nothing is damaged")
    {
        CHECK(tidy_store(store, 0, true).removed.size() == 1);
        CHECK(tidy_store(store, 0, false).removed.size() == 1);
        CHECK(names_in(store.root() / "objects") == std::vector<std::string>{used.object});
        CHECK(names_in(store.root() / "keys") == std::vector<std::string>{"used.json"});
        CHECK(names_in(store.root() / "locks") == std::vector<std::string>{"store"});
        CHECK(records() == 1);
    }
    SECTION("a damaged record may have named any result of its stage")
    {
        for (const auto& entry : fs::recursive_directory_iterator(stages))
            if (entry.is_regular_file())
                write(entry.path(), "damage");
        CHECK(tidy_store(store, 0, false).removed.empty());
        CHECK(store.present(used));
    }
    SECTION("a pipeline that may not be looked at may be there")
    {
        fs::remove(pipeline);
        fs::create_symlink(pipeline, pipeline);
        CHECK(tidy_store(store, 0, false).removed.size() == 1);
        CHECK(store.present(used));
    }
}

TEST_CASE("A lock that was tidied away is made again")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    FileLock first(store.lock_file("key"));
    FileLock second(store.lock_file("key"));
    REQUIRE(first.try_exclusive());
    fs::remove(store.lock_file("key"));
    FileLock third(store.lock_file("key"));
    CHECK(third.try_exclusive());
    first = FileLock();
    CHECK(!second.try_exclusive());
}

TEST_CASE("An unreadable record of a key counts as none")
{
    const TemporaryFolder folder;
    const Store store(folder.path());
    publish_text(store, "key", "[1]");
    const std::string whole = fresco::read_text_file(store.key_file("key"));
    for (const std::string& text : {std::string("{"), std::string(), whole.substr(1)})
    {
        write(store.key_file("key"), text);
        CHECK(!store.lookup("key"));
    }
}
