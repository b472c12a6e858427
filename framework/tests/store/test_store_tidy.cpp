#include "store_samples.h"

#include "store/stage_record.h"
#include "store/store_tidy.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <array>
#include <linux/capability.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

using namespace fresco::host;
using fresco::content_hash;
using fresco::testing::TemporaryFolder;

TEST_CASE("A store of another format is refused with both and with what to do")
{
    const TemporaryFolder folder;
    const fs::path format = folder.path() / "format";
    fresco::write_checked(format, "fresco store 7\n");
    CHECK_THROWS_WITH(Store(folder.path()), Contains("\"fresco store 7\"") && Contains("\"fresco store 2\"") &&
                                                Contains("remove " + folder.path().string()));
    write(format, "A4");
    CHECK_THROWS_WITH(Store(folder.path()), Contains("format: is not the file of a store"));
    CHECK(names_in(folder.path()) == Words{"format"});
}

TEST_CASE("A folder that is neither empty nor a store is refused as one")
{
    const TemporaryFolder folder;
    const std::string mine = GENERATE("objects/thesis.pdf", "notes", "format/notes", ".fresco-thesis");
    write(folder.path() / mine, "mine");
    CHECK_THROWS_AS(Store(folder.path()), fresco::Error);
    CHECK(names_in(folder.path()).size() == 1);
    CHECK(fresco::read_text_file(folder.path() / mine) == "mine");
}

TEST_CASE("A store whose maker was killed is made again")
{
    const TemporaryFolder folder;
    write(folder.path() / (".fresco-" + content_hash("draft")), "fresco st");
    Store(folder.path());
    CHECK(Store::is_at(folder.path()));
}

TEST_CASE("Names that no store makes are neither listed nor removed")
{
    const OwnStore store;
    const std::string key = content_hash("unused");
    const auto unused = publish_text(store, key, "[1]");
    const fs::path gone = store.path() / "gone.yaml";
    write_stage_record(store, gone, {"s", key, unused.object, {}});
    const std::vector<fs::path> mine{"objects/thesis/manifest.json",
                                     "objects/thesis.pdf",
                                     "keys/" + key + ".txt",
                                     "keys/thesis.json",
                                     "logs/" + key + ".txt",
                                     "stages/thesis/s.json",
                                     "stages/thesis/.fresco-" + key,
                                     pipeline_folder(store, gone).lexically_relative(store.root()) / "notes.txt",
                                     "checkpoints/thesis",
                                     "locks/thesis",
                                     "tmp/thesis/a",
                                     "notes.txt"};
    for (const fs::path& file : mine)
        write(store.root() / file, "mine");
    CHECK(list_objects(store).size() == 1);
    CHECK(tidy_store(store, 0, false).removed.size() == 1);
    CHECK(names_in(store.root() / "objects") == Words{"thesis", "thesis.pdf"});
    for (const fs::path& file : mine)
        CHECK(fresco::read_text_file(store.root() / file) == "mine");
}

TEST_CASE("Results of a pipeline's last run stay for keep_days, though its file cannot be seen")
{
    const OwnStore store;
    const fs::path pipeline = store.path() / "unmounted/room.yaml";
    const auto below = publish_text(store, content_hash("below"), "[0]");
    const auto result = publish_text(store, content_hash("key"), "[1]", {}, {below.object});
    const StageRecord record{"s", content_hash("key"), result.object, {}};
    write_stage_record(store, pipeline, record);
    const fs::path file = pipeline_folder(store, pipeline) / "s.json";
    touch(file, 24 * 6);
    double disk_mb = 0;
    for (const StoredObject& object : list_objects(store))
        disk_mb += object.disk_mb;
    const TidyResult kept = tidy_store(store, 7, false);
    CHECK(kept.removed.empty());
    CHECK(kept.kept == 2);
    CHECK(kept.kept_mb == Approx(disk_mb));
    CHECK(disk_mb > 0);
    touch(file, 24 * 8);
    CHECK(tidy_store(store, 7, true).removed.size() == 2);
    write_stage_record(store, pipeline, record);  // Another run writes the same record.
    CHECK(tidy_store(store, 7, false).removed.empty());
    touch(file, 24 * 8);
    CHECK(tidy_store(store, 7, false).kept == 0);
    CHECK(!fs::exists(pipeline_folder(store, pipeline)));
    CHECK(!store.present(result));
}

TEST_CASE("A folder that its owner may not list or change is removed, and one that stays is named")
{
    const OwnStore store;
    const fs::path left = store.make_temporary();
    write(left / "closed/a", "");
    write(left / "read_only/a", "");
    fs::permissions(left / "closed", fs::perms::none);
    fs::permissions(left / "read_only", fs::perms::owner_read | fs::perms::owner_exec);
    in_processes(1,
                 [&](int)
                 {
                     // Root without capabilities is forbidden what other owners are.
                     __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
                     std::array<__user_cap_data_struct, 2> none{};
                     if (syscall(SYS_capset, &header, none.data()) != 0)
                         throw fresco::Error("the test cannot give up its capabilities");
                     if (const TidyResult tidied = tidy_store(store, 0, false); tidied.leftovers != 1 || !tidied.stuck.empty())
                         throw fresco::Error("the folder stays");
                 });
    CHECK(!fs::exists(left));
}

TEST_CASE("Tidying up keeps what is in use, and leaves nothing that serves nobody")
{
    const OwnStore store;
    const fs::path pipeline = store.path() / "room.yaml";
    write(pipeline, "version: 1");
    write(store.path() / "gone.yaml", "version: 1");
    const std::string used_key = content_hash("used");
    const std::string unused_key = content_hash("unused");
    const auto used = publish_text(store, used_key, "[1]");
    const auto unused = publish_text(store, unused_key, "[2]");
    write_stage_record(store, pipeline, {"s", used_key, used.object, {}});
    write_stage_record(store, store.path() / "gone.yaml", {"s", unused_key, unused.object, {}});
    fs::remove(store.path() / "gone.yaml");
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
        CHECK(names_in(store.root() / "objects") == Words{used.object});
        CHECK(names_in(store.root() / "keys") == Words{".fresco-thesis", used_key + ".json"});
        CHECK(names_in(store.root() / "locks") == Words{"store", "thesis"});
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
    SECTION("what cannot be listed is an error, and nothing is removed")
    {
        fs::remove_all(stages);
        write(stages, "no folder");
        CHECK_THROWS_WITH(tidy_store(store, 0, false), Contains("stages: is a file in place of a folder: remove it"));
        CHECK(store.present(unused));
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
    const OwnStore store;
    FileLock first(store.lock_file("key"));
    FileLock second(store.lock_file("key"));
    REQUIRE(first.try_exclusive());
    fs::remove(store.lock_file("key"));
    FileLock third(store.lock_file("key"));
    CHECK(third.try_exclusive());
    first = FileLock();
    CHECK(!second.try_exclusive());
}

TEST_CASE("The only process in a store removes what killed ones left there, and nothing else")
{
    const OwnStore store;
    const fs::path left = store.make_temporary();
    const fs::path of_worker = store.make_temporary(left.filename());
    write(store.root() / "tmp/other/a", "mine");
    FileLock run = store_lock(store);
    FileLock other = store_lock(store);
    REQUIRE(other.try_shared());
    CHECK(enter_store(store, run));
    CHECK_THROWS_WITH(tidy_store(store, 0, false), Contains("a run is using the store"));
    CHECK(names_in(store.root() / "tmp").size() == 3);
    other = FileLock();
    const bool by_run = GENERATE(false, true);
    if (!by_run)
        run = FileLock();
    CHECK((by_run ? enter_store(store, run) : tidy_store(store, 0, false).leftovers == 2));
    CHECK(names_in(store.root() / "tmp") == Words{"other"});
    FileLock gc = store_lock(store);
    if (!by_run && gc.try_exclusive())
        CHECK(!enter_store(store, run = store_lock(store)));
}
