#include "store_samples.h"

#include "store/publish.h"
#include "store/store_tidy.h"
#include <fresco/error.h>

using namespace fresco::host;
using fresco::testing::TemporaryFolder;

namespace
{

const auto no_wait = [] {};

}  // namespace

TEST_CASE("Results are copied with what they refer to, once")
{
    const TemporaryFolder folder;
    const Store from(folder.path() / "from");
    const Store to(folder.path() / "to");
    const auto below = publish_text(from, "below", "[1]");
    const auto top = publish_text(from, "top", "[2]", {}, {below.object});
    const auto other = publish_text(from, "other", "[3]");
    fs::create_directory(from.object(top.object) / "empty");

    const CopiedResults some = copy_results(from, to, {top.object}, no_wait);
    CHECK(some.copied == 2);
    CHECK(some.damages.empty());
    REQUIRE(to.lookup("top"));
    CHECK(to.present(*to.lookup("top")));
    CHECK(to.lookup("below"));
    CHECK(fs::is_directory(to.object(top.object) / "empty"));
    CHECK(fresco::read_text_file(to.manifest_file(top.object)) == fresco::read_text_file(from.manifest_file(top.object)));

    const CopiedResults all = copy_results(from, to, {}, no_wait);
    CHECK(all.copied == 1);
    CHECK(all.there == 2);
    CHECK(verify_store(to, 1).empty());
    CHECK(list_objects(to).size() == 3);
    CHECK(fs::is_empty(to.root() / "tmp"));
    CHECK_THROWS_WITH(copy_results(from, to, {"0123456789abcdef0123456789abcdef"}, no_wait), Catch::Contains("no such result"));
    CHECK(to.present(other.object));
}

TEST_CASE("A damaged result is not copied, nor what refers to it")
{
    const TemporaryFolder folder;
    const Store from(folder.path() / "from");
    const Store to(folder.path() / "to");
    const auto below = publish_text(from, "below", "[1]");
    const auto top = publish_text(from, "top", "[2]", {}, {below.object});
    SECTION("a file")
    {
        write(from.object(below.object) / "out/a.json", "[9]");
    }
    SECTION("a manifest")
    {
        write(from.manifest_file(below.object), "{}");
    }
    const CopiedResults done = copy_results(from, to, {top.object}, no_wait);
    CHECK(done.copied == 0);
    REQUIRE(done.damages.size() == 1);
    CHECK(contains(done.damages.front().text, below.object));
    CHECK(fs::is_empty(to.root() / "objects"));
    CHECK(fs::is_empty(to.root() / "tmp"));
}

TEST_CASE("Copies of the same results at once leave each whole, once")
{
    const TemporaryFolder folder;
    const Store from(folder.path() / "from");
    const Store to(folder.path() / "to");
    for (int i = 0; i < 20; ++i)
        publish_text(from, "key" + std::to_string(i), "[" + std::to_string(i) + "]");
    in_processes(3,
                 [&](int)
                 {
                     const CopiedResults done = copy_results(from, to, {}, no_wait);
                     if (done.copied + done.there != 20 || !done.damages.empty())
                         throw fresco::Error("not all were copied");
                 });
    CHECK(list_objects(to).size() == 20);
    CHECK(verify_store(to, 1).empty());
    CHECK(fs::is_empty(to.root() / "tmp"));
}
