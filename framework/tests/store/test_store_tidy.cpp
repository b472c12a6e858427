#include "store_samples.h"

#include "store/stage_record.h"
#include "store/store_tidy.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <sys/stat.h>

using namespace fresco::host;
using fresco::content_hash;
using fresco::testing::TemporaryFolder;

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
    const std::string used_key = content_hash("used");
    const std::string unused_key = content_hash("unused");
    const auto used = publish_text(store, used_key, "[1]");
    const auto unused = publish_text(store, unused_key, "[2]");
    write_stage_record(store, pipeline, {"s", used_key, used.object, {}});
    write_stage_record(store, folder.path() / "gone.yaml", {"s", unused_key, unused.object, {}});
    fs::remove(folder.path() / "gone.yaml");
    for (const std::string& key : {used_key, unused_key, std::string("store"), std::string("thesis")})
        FileLock(store.lock_file(key)).try_exclusive();
    write(store.root() / "keys" / (".fresco-" + unused_key), "left by a killed writer");
    write(store.root() / "keys" / ".fresco-thesis", "somebody else's");
    const fs::path stages = store.root() / "stages";
    const auto records = [&] { return std::distance(fs::directory_iterator(stages), {}); };
    REQUIRE(records() == 2);

    SECTION("nothing is damaged")
    {
        CHECK(tidy_store(store, 0, true).removed.size() == 1);
        CHECK(tidy_store(store, 0, false).removed.size() == 1);
        CHECK(names_in(store.root() / "objects") == std::vector<std::string>{used.object});
        CHECK(names_in(store.root() / "keys") == std::vector<std::string>{".fresco-thesis", used_key + ".json"});
        CHECK(names_in(store.root() / "locks") == std::vector<std::string>{"store", "thesis"});
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

TEST_CASE("What cannot be removed or listed is an error, and nothing else is removed")
{
    const TemporaryFolder folder;
    const Store store(folder.path() / "store");
    const StoredResult result = publish_text(store, "key", "text");
    SECTION("a folder in place of a manifest is damage")
    {
        fs::remove(store.manifest_file(result.object));
        fs::create_directories(store.manifest_file(result.object) / "in the way");
        CHECK(!store.present(result));
        CHECK(store.present(publish_text(store, "key", "text")));
    }
    SECTION("the records of what is in use")
    {
        fs::remove(store.root() / "stages");
        write(store.root() / "stages", "no folder");
        CHECK_THROWS_WITH(tidy_store(store, 0, false), Catch::Contains("stages: is a file in place of a folder: remove it"));
        CHECK(store.present(result));
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
