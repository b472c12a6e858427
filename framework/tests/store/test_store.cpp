#include "store_samples.h"

#include "store/store_tidy.h"
#include <fresco/error.h>

#include <sys/stat.h>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

TEST_CASE("A published result is found by its key, whole, and damage to it is named")
{
    const OwnStore store;
    CHECK(!store.lookup("key"));
    const mode_t before = umask(022);
    const StoredResult result = publish_text(store, "key", "[1]");
    umask(before);
    CHECK(fs::status(store.object(result.object)).permissions() == fs::perms(0755));
    const auto found = store.lookup("key");
    REQUIRE((found && found->object == result.object && store.present(*found)));
    CHECK(!store.verify(result.object, 2));
    CHECK(fs::is_empty(store.root() / "tmp"));

    const fs::path file = store.object(result.object) / "out" / "a.json";
    const auto damage = [&](const std::string& output = "")
    { return store.verify(result.object, 2, output).value_or(Damage{}).text; };
    SECTION("a file that is flipped, cut or missing")
    {
        write(file, "[2]");
        CHECK(contains(damage(), "a.json"));
        CHECK(!store.verify(publish_text(store, "other", "[1]").object, 2));
        fs::resize_file(file, 1);
        CHECK(contains(damage(), "has 1 bytes, 3 were written"));
        fs::remove(file);
        CHECK(!damage().empty());
    }
    SECTION("an output that the manifest does not list")
    {
        CHECK(damage("other").empty());
        fs::create_directory(store.object(result.object) / "other");
        CHECK(contains(damage("other"), "not among the files of the result"));
    }
    SECTION("a changed or emptied manifest")
    {
        const std::string whole = fresco::read_text_file(store.manifest_file(result.object));
        std::string changed = whole;
        changed.replace(changed.find("t.t"), 3, "u.u");
        for (const std::string& text : {changed, std::string(), std::string("{}"), std::string("{\"files\":[]}")})
        {
            write(store.manifest_file(result.object), text);
            CHECK(contains(damage(), "checksum"));
        }
        CHECK(publish_text(store, "key", "[1]").object == result.object);
        CHECK(damage().empty());
    }
    SECTION("another result's folder")
    {
        const StoredResult other = publish_text(store, "other", "[2]");
        fs::rename(store.object(result.object), store.root() / "aside");
        fs::rename(store.object(other.object), store.object(result.object));
        CHECK(contains(damage("out"), "the manifest of another result"));
    }
    SECTION("a folder without a manifest, or with a folder in its place, is garbage and is replaced")
    {
        fs::remove(store.manifest_file(result.object));
        if (GENERATE(false, true))
            fs::create_directories(store.manifest_file(result.object) / "in the way");
        write(file, "half");
        CHECK(!store.present(*found));
        CHECK(publish_text(store, "key", "[1]").object == result.object);
        CHECK(damage().empty());
    }
    SECTION("a removed result is not there any more")
    {
        store.discard(result.object);
        CHECK(!store.present(*store.lookup("key")));
        CHECK(fs::is_empty(store.root() / "tmp"));
        CHECK(fs::is_empty(store.root() / "objects"));
    }
}

TEST_CASE("Files of several pieces are verified piece by piece")
{
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "big";
    write(file, std::string(9U << 20U, 'x'));
    const StoredFile hashed = hash_chunks(folder.path(), "big");
    CHECK(hashed.size == 9U << 20U);
    REQUIRE(hashed.chunks.size() == 3);
    CHECK(hashed.chunks[0] == hashed.chunks[1]);
    CHECK(hashed.chunks[2] != hashed.chunks[1]);
    CHECK(!find_damage(folder.path(), hashed));
    std::fstream(file, std::ios::in | std::ios::out).seekp(5 << 20) << 'y';
    CHECK(contains(find_damage(folder.path(), hashed).value(), "from 4194304 on"));
    write(folder.path() / "empty", "");
    CHECK(!find_damage(folder.path(), hash_chunks(folder.path(), "empty")));
}

TEST_CASE("Outside files: touched is the same, changed is another, changed back is the first again")
{
    const OwnStore store;
    const fs::path input = store.path() / "input";
    write(input, "one");
    const auto first = publish_text(store, "key", "[1]", {take_dependency(input, false)});
    touch(input, 1);
    CHECK(store.lookup("key").value().object == first.object);

    // Also where the new stamp cannot be written down: there is a folder in place of the lock.
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

TEST_CASE("Files read next to an input do not stand for those next to an equal input")
{
    const OwnStore store;
    const fs::path one = store.path() / "one/model";
    const fs::path other = store.path() / "other/model";
    for (const fs::path& file : {one, other, store.path() / "one/color"})
        write(file, "equal");
    publish_text(store, "alone", "[1]");
    CHECK(store.lookup("alone", nullptr, {other}));
    publish_text(store, "key", "[1]", {take_dependency(store.path() / "one/color", false), take_dependency(one, false)});
    std::string why;
    CHECK(store.lookup("key", &why, {one}));
    CHECK(!store.lookup("key", &why, {other}));
    CHECK(contains(why, other.string()));
}

TEST_CASE("A key keeps its last eight results; results refer to others, and are there only if those are")
{
    const OwnStore store;
    for (int i = 0; i < 10; ++i)
        store.remember("key", {object_prefix("key") + std::to_string(i), {}, {}});
    CHECK(store.lookup("key").value().object == object_prefix("key") + "9");
    const auto record = fresco::parse_json(fresco::read_text_file(store.key_file("key")));
    CHECK(record.at("results").as_list().size() == 8);

    const auto below = publish_text(store, "below", "[1]");
    const auto middle = publish_text(store, "middle", "[2]", {}, {below.object});
    const auto top = publish_text(store, "top", "[3]", {}, {middle.object});
    CHECK((middle.references == std::vector{below.object} && top.references.size() == 2));
    CHECK(store.present(top));
    store.discard(below.object);
    CHECK(!store.present(top));
}

TEST_CASE("What cannot be stored is refused by name and nothing is published")
{
    const OwnStore store;
    const fs::path made = store.make_temporary();
    write(made / "out" / "a.json", "1");
    const std::string name = GENERATE("link", "fifo", "caf\xe9.txt");  // A manifest holds only names in UTF-8.
    const fs::path file = made / "out" / name;
    if (name == "link")
        fs::create_symlink("/etc", file);
    else if (name == "fifo")
        mkfifo(file.c_str(), 0600);
    else
        write(file, "1");
    CHECK_THROWS_WITH(publish(store, made, {"key", {"out"}, {}, fresco::Value::Map{}}), Contains(name));
    CHECK(!store.lookup("key"));
}
