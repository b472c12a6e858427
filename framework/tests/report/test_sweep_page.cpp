#include "program.h"

#include "report/sweep_summary.h"

using namespace fresco::host;

namespace
{

std::size_t occurrences(const std::string& text, const std::string& part)
{
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

const char* const sweep = R"(version: 1
vars: {n: }
matrix: {n: [110, 120, 130]}
stages:
  one:  {type: test.source, value: "${n}"}
  view: {type: test.sink, input: one, path: view.png}
)";

}  // namespace

TEST_CASE("pictures of a combination: of the last stage that made some only for it, evenly spaced")
{
    Pipeline pipeline;
    for (const auto& [own_name, place] : {std::pair{"views", "a"}, {"last", ""}, {"text", "a"}, {"extra", "a"}})
    {
        PipelineStage stage;
        stage.name = stage.own_name = own_name;
        stage.place = place;
        pipeline.stages.push_back(stage);
    }
    const Combination combination{"a", {"a"}, {0, 1, 2, 3}};
    RunSummary summary;
    CombinationOutcome outcome;
    outcome.combination = &combination;
    const auto add = [&](const char* stage, const std::string& name)
    {
        outcome.files.push_back(summary.files.size());
        summary.files.push_back({stage, "/out/" + name, true});
    };
    for (int i = 0; i < 10; ++i)
        add("views", std::to_string(i) + ".png");
    add("last", "last.jpg");
    add("text", "a.txt");
    using Numbers = std::vector<std::size_t>;
    const std::vector<std::string> extensions{".png", ".jpg", ".jpeg"};
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "", 1) == Numbers{5});
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "", 3) == Numbers{1, 5, 8});
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "", 20).size() == 10);
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "last", 3) == Numbers{10});
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "text", 3).empty());
    add("extra", "b.jpeg");
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "", 3) == Numbers{12});
    outcome.files.clear();
    CHECK(pictures_of(pipeline, summary, outcome, extensions, "", 3).empty());
}

TEST_CASE("a sweep ends with a page of small pictures, which stays where nothing is new")
{
    Workplace place({"good", "pictures"});
    place.write("sweep.yaml", sweep);
    const Finished first = place.run({"run", "sweep.yaml"});
    CHECK(first.code == 0);
    CHECK(contains(first.out, "out/sweep.html"));
    const std::string html = place.read("out/sweep.html");
    for (const char* text : {"480px of 110", "480px of 120", "480px of 130"})
        CHECK(occurrences(html, text) == 1);
    const auto data = page_json(html, "data");
    const auto& second = data.at("combinations").as_list().at(1);
    CHECK(second.at("pictures") == fresco::Value(fresco::Value::List{"n=120/view.png"}));
    CHECK(second.at("report").as_string() == "n=120/report.html");
    CHECK(second.at("stages").as_list().size() == 2);
    const auto written = fresco::parse_json(place.read("out/sweep.json"), "sweep.json");
    CHECK(written.at("stages") == data.at("stages"));
    CHECK(written.at("stages").as_list().at(0).at("figures").find("threads") != nullptr);
    const auto media = page_json(html, "media");
    CHECK(media.as_list().at(1).at("folder").as_string() == "n=120");
    REQUIRE(place.run({"run", "sweep.yaml"}).code == 0);
    CHECK(place.read("out/sweep.html") == html);
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "n=[110, 140]"}).code == 0);
    CHECK(occurrences(place.read("out/sweep.html"), "data:,480px of 140") == 1);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
    CHECK(contains(place.run({"run", "sweep.yaml", "--thumbnails", "veiw"}).err,
                   "--thumbnails veiw: error: unknown stage 'veiw' (did you mean 'view'?)"));
    REQUIRE(place.run({"run", "sweep.yaml", "--thumbnails", "one"}).code == 0);
    CHECK(page_json(place.read("out/sweep.html"), "media").as_list().empty());
}

TEST_CASE("while a page is made the store is in use")
{
    Workplace place({"good", "pictures"});
    place.write("sweep.yaml", sweep);
    const auto run = place.start({"run", "sweep.yaml", "--no-report", "--set", "n=[15, 110]"});
    Workplace::wait_until([&] { return fs::exists(place.file("open")); });
    const fresco::host::Store store(place.file(".fresco"));
    CHECK_FALSE(fresco::host::store_lock(store).try_exclusive());
    fs::remove(place.file("open"));
    CHECK(run->wait().code == 0);
    CHECK(occurrences(place.read("out/sweep.html"), "data:,480px of 15") == 1);
    CHECK(fresco::host::store_lock(store).try_exclusive());
}

TEST_CASE("where a picture cannot be opened the page is there all the same")
{
    const bool plugin = GENERATE(true, false);
    Workplace place(plugin ? std::vector<std::string>{"good", "pictures"} : std::vector<std::string>{"good"});
    place.write("sweep.yaml", sweep);
    // The reader crashes, or there is none.
    const Finished crash = place.run({"run", "sweep.yaml", "--set", "n=[13, 110]"});
    CHECK(crash.code == 0);
    CHECK(contains(plugin ? crash.err : place.read("out/sweep.html"),
                   plugin ? "ended by Segmentation fault" : "no plugin shows artifacts"));
    CHECK(contains(place.read("out/sweep.html"), "\"pictures\":[\"n=110/view.png\"]"));
    if (!plugin)
        return;
    // One picture is broken, the other is not.
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "n=[14, 110]"}).code == 0);
    const std::string html = place.read("out/sweep.html");
    CHECK(contains(html, "view.png: is cut"));
    CHECK(contains(html, "data:,480px of 110"));
}
