#include "store_samples.h"

#include <fresco/error.h>

#include <sys/stat.h>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

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
        CHECK_FALSE(store.verify(result.object, 2, "other"));
        fs::create_directory(store.object(result.object) / "other");
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
    const TemporaryFolder folder;
    const Store store(folder.path() / "store");
    const fs::path one = folder.path() / "one/model";
    const fs::path other = folder.path() / "other/model";
    for (const fs::path& file : {one, other, folder.path() / "one/color"})
        write(file, "equal");
    publish_text(store, "alone", "[1]");
    CHECK(store.lookup("alone", nullptr, {other}));
    publish_text(store, "key", "[1]", {take_dependency(folder.path() / "one/color", false), take_dependency(one, false)});
    std::string why;
    CHECK(store.lookup("key", &why, {one}));
    CHECK(!store.lookup("key", &why, {other}));
    CHECK(contains(why, other.string()));
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

TEST_CASE("Text that looks like a path into the store is not a reference")
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
