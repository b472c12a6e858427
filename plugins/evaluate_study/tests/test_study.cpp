#include "catch.h"
#include "small_study.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <set>

using namespace study;
using Catch::Contains;

namespace
{

std::vector<Group> two_groups(const std::filesystem::path& folder)
{
    std::vector<Group> groups;
    for (const char* name : {"one", "two"})
    {
        Group group{name, {}};
        for (const char* method : {"a", "b"})
        {
            group.files[method] = folder / (std::string(name) + method);
            fresco::write_file(group.files[method], std::string(name) + method);
        }
        groups.push_back(group);
    }
    return groups;
}

}  // namespace

TEST_CASE("pictures of equal names are compared, so many of them at most, evenly spread")
{
    MethodPictures a{"a", {}};
    MethodPictures b{"b", {}};
    for (int i = 0; i < 10; ++i)
    {
        a.files["view-" + std::to_string(i)] = "a" + std::to_string(i);
        b.files["view-" + std::to_string(i + 2)] = "b" + std::to_string(i);
    }
    const auto all = compared_groups({a, b}, 100);
    REQUIRE(all.size() == 8);
    CHECK(all[0].name == "view-2");
    CHECK(all[0].files.at("a") == "a2");
    CHECK(all[0].files.at("b") == "b0");
    const auto some = compared_groups({a, b}, 2);
    REQUIRE(some.size() == 2);
    // The middles of two halves.
    CHECK(some[0].name == "view-4");
    CHECK(some[1].name == "view-8");

    CHECK_THROWS_WITH(compared_groups({}, 5), Contains("found none"));
    CHECK_THROWS_WITH(compared_groups({a}, 5), Contains("found one"));
    CHECK_THROWS_WITH(compared_groups({a, a}, 5), Contains("two methods are named a"));
    MethodPictures other{"other", {{"x", "x.png"}}};
    CHECK_THROWS_WITH(compared_groups({a, other}, 5), Contains("a has view-0, … and other has x;"));
}

TEST_CASE("every two methods with a view in common are compared")
{
    const auto found = comparisons(small_study());
    REQUIRE(found.size() == 2);
    CHECK(found[0].first == "a");
    CHECK(found[0].second == "b");
    CHECK(found[0].pairs == std::vector<std::pair<std::size_t, std::size_t>>{{2, 0}, {1, 3}});
    CHECK(found[1].first == "b");
    CHECK(found[1].second == "c");
    CHECK(found[1].pairs == std::vector<std::pair<std::size_t, std::size_t>>{{5, 4}});
}

TEST_CASE("a study's id is of all that it is made of, its numbers of the seed")
{
    const fresco::testing::TemporaryFolder folder;
    auto groups = two_groups(folder.path());
    const Study made = make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90");
    CHECK(made.id.size() == 32);
    CHECK(made.id == make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90").id);
    std::set<std::pair<std::string, std::string>> pictures;
    for (const Picture& picture : made.pictures)
        pictures.emplace(picture.method, picture.name);
    CHECK(pictures == std::set<std::pair<std::string, std::string>>{{"a", "one"}, {"b", "one"}, {"a", "two"}, {"b", "two"}});
    bool other_order = false;
    for (std::uint64_t seed = 2; seed < 6; ++seed)
        other_order = other_order || !(make_study(groups, {"Which?"}, 5, {}, seed, "960jpeg90").pictures == made.pictures);
    CHECK(other_order);

    std::set<std::string> ids{made.id};
    CHECK(ids.insert(make_study(groups, {"Why?"}, 5, {}, 1, "960jpeg90").id).second);
    CHECK(ids.insert(make_study(groups, {"Which?"}, 6, {}, 1, "960jpeg90").id).second);
    CHECK(ids.insert(make_study(groups, {"Which?"}, 5, {}, 1, "960png90").id).second);
    fresco::write_file(groups[1].files["b"], "repainted");
    CHECK(ids.insert(make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90").id).second);
}

TEST_CASE("questions are separated by a bar")
{
    CHECK(split_questions("One?") == std::vector<std::string>{"One?"});
    CHECK(split_questions(" One? |Two, or\nthree? \n") == std::vector<std::string>{"One?", "Two, or\nthree?"});
    CHECK_THROWS_WITH(split_questions("One? |"), Contains("a question is empty"));
    CHECK_THROWS_WITH(split_questions(""), Contains("a question is empty"));
}

TEST_CASE("a key gives the study back, and only as it was written")
{
    const Study study = small_study();
    const std::string text = key_text(study);
    const Study read = key_from(text, "study.key.json");
    CHECK(read.id == study.id);
    CHECK(read.questions == study.questions);
    CHECK(read.pictures == study.pictures);
    CHECK(read.pairs_count == 6);
    CHECK(key_text(read) == text);
    const auto changed = [&](const std::string& from, const std::string& to)
    {
        std::string other = text;
        other.replace(other.find(from), from.size(), to);
        return other;
    };
    CHECK_THROWS_WITH(key_from(changed("study_key", "other"), "k.json"), Contains("k.json: not the key of a study, version 1"));
    CHECK_THROWS_WITH(key_from(changed("\"version\": 1", "\"version\": 2"), "k.json"),
                      Contains("not the key of a study, version 1"));
    CHECK_THROWS_WITH(key_from(changed("\"pairs_count\"", "\"pairs\""), "k.json"), Contains("k.json: ") && Contains("pairs"));
    CHECK_THROWS_WITH(key_from(changed("\"version\": 1,", "\"version\": 1, \"more\": 2,"), "k.json"),
                      Contains("unknown entry 'more'"));
    CHECK_THROWS_WITH(key_from(changed("\"name\": \"two\"", "\"name\": \"one\""), "k.json"), Contains("one of a appears twice"));
    CHECK_THROWS_WITH(key_from("{]", "k.json"), Contains("k.json: not valid JSON"));
}

TEST_CASE("a study of one method against the others, with its questions mixed and hints")
{
    Study study = small_study();
    study.design.ours = "c";
    auto compared = comparisons(study);
    REQUIRE(compared.size() == 1);
    CHECK(compared[0].first == "b");
    CHECK(compared[0].second == "c");
    study.design.ours = "b";
    CHECK(comparisons(study).size() == 2);
    study.pictures.push_back({"c", "one"});
    CHECK(comparisons(study).size() == 2);  // c and a share a view now, but are not compared

    study.design.mixes_questions = true;
    study.design.hints = {{"one", {}, 0.25, 0, 0.5, 1}, {"two", 1, 0, 0.5, 0.125, 0.25}};
    const Study read = key_from(key_text(study), "key");
    CHECK(read.design.ours == "b");
    CHECK(read.design.mixes_questions);
    CHECK(read.design.hints == study.design.hints);

    fresco::testing::TemporaryFolder folder;
    const auto groups = two_groups(folder.path());
    const auto made = [&](Design design) { return make_study(groups, {"Which?"}, 5, std::move(design), 1, "960jpeg90").id; };
    const std::set<std::string> ids{made({}), made({"a", false, {}}), made({"", true, {}}),
                                    made({"", false, {{"one", 0, 0, 0, 1, 1}}})};
    CHECK(ids.size() == 4);
    CHECK_THROWS_WITH(made({"z", false, {}}), Contains("no method is called z"));
    CHECK_THROWS_WITH(made({"", false, {{"none", 0, 0, 0, 1, 1}}}), Contains("the view none"));
    CHECK_THROWS_WITH(made({"", false, {{"one", 3, 0, 0, 1, 1}}}), Contains("question 3"));
}

TEST_CASE("hints are read strictly")
{
    const auto read = [](const std::string& entry) { return hints_from("[{" + entry + "}]", "hints.json"); };
    const auto hints = read(R"("view": "one", "question": 1, "left": 0.5, "top": 0, "width": 0.5, "height": 0.25)");
    REQUIRE(hints.size() == 1);
    CHECK(hints[0] == Hint{"one", 1, 0.5, 0, 0.5, 0.25});
    CHECK_FALSE(read(R"("view": "one", "left": 0.5, "top": 0, "width": 0.5, "height": 0.25)")[0].question);
    for (const char* wrong :
         {R"("view": "one", "left": 0.6, "top": 0, "width": 0.5, "height": 1)",
          R"("view": "one", "left": 0, "top": 0, "width": 0, "height": 1)", R"("view": "one", "left": 0, "top": 0, "width": 1)",
          R"("view": 1, "left": 0, "top": 0, "width": 1, "height": 1)",
          R"("view": "one", "left": 0, "top": 0, "width": 1, "height": 1, "color": 1)",
          R"("view": "one", "question": -1, "left": 0, "top": 0, "width": 1, "height": 1)"})
        CHECK_THROWS_WITH(read(wrong), Contains("hints.json[0]"));
}
